// The pages of the book that the page shows beside itself, as HTML without pictures.
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { Marked, type Tokens } from "marked";
import type { Plugin } from "vite";
import PAGES from "./src/help/pages.json" with { type: "json" };

const BOOK = pathToFileURL(`${join(import.meta.dirname, "../docs")}/`);

/** The route of the page that a link of the book leads to, or null. */
function routeOf(href: string, from: string): string | null {
  const to = new URL(href, new URL(`${from}.md`, BOOK)).pathname;
  const found = Object.entries(PAGES).find(([, page]) => to === new URL(`${page}.md`, BOOK).pathname);
  return found?.[0] ?? null;
}

/** A page of the book, in HTML. Links to other pages of the book lead to help of their routes; others are text. */
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

/** Gives each page of the table as `assets/help.json`: HTML by route. */
export const help = (): Plugin => ({
  name: "help",
  generateBundle() {
    const pages = Object.fromEntries(Object.entries(PAGES).map(([route, page]) => [route, helpOf(page)]));
    this.emitFile({ type: "asset", fileName: "assets/help.json", source: JSON.stringify(pages) });
  },
});
