// Pages of the book that the studio shows as help, as HTML without pictures.
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { Marked, type Tokens } from "marked";
import type { Plugin } from "vite";
import PAGES from "./src/help/pages.json" with { type: "json" };

const BOOK = pathToFileURL(`${join(import.meta.dirname, "../docs")}/`);

/** Route of the studio to which a link of the book leads; null without one. */
function routeOf(href: string, from: string): string | null {
  const to = new URL(href, new URL(`${from}.md`, BOOK)).pathname;
  const found = Object.entries(PAGES).find(([, page]) => to === new URL(`${page}.md`, BOOK).pathname);
  return found?.[0] ?? null;
}

/**
 * Converts a page of the book to HTML. Links to other pages of the book lead to the help of their
 * routes; all others become text.
 */
export function helpOf(page: string): string {
  const renderer = {
    image: () => "",
    html: () => "",
    link(this: { parser: { parseInline(tokens: Tokens.Generic[]): string } }, { href, tokens }: Tokens.Link): string {
      const text = this.parser.parseInline(tokens as Tokens.Generic[]);
      if (/^https:/.test(href)) return `<a href="${href}" target="_blank" rel="noreferrer">${text}</a>`;
      const route = routeOf(href, page);
      return route === null ? text : `<a href="#/${route}">${text}</a>`;
    },
  };
  const text = readFileSync(new URL(`${page}.md`, BOOK), "utf8");
  return String(new Marked({ renderer, async: false }).parse(text));
}

/** Vite plugin that writes the pages of the table as `assets/help.json`: HTML by route. */
export const help = (): Plugin => ({
  name: "help",
  generateBundle() {
    const pages = Object.fromEntries(Object.entries(PAGES).map(([route, page]) => [route, helpOf(page)]));
    this.emitFile({ type: "asset", fileName: "assets/help.json", source: JSON.stringify(pages) });
  },
});
