import { existsSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { expect, test } from "vitest";
import { helpOf } from "../../help";
import { ROUTES } from "../store";
import PAGES from "./pages.json";

const book = (page: string) => join(import.meta.dirname, `../../../docs/${page}.md`);

test("every route has an existing page of the book", () => {
  expect(Object.keys(PAGES).toSorted()).toEqual([...ROUTES].toSorted());
  for (const page of Object.values(PAGES)) expect([page, existsSync(book(page))]).toEqual([page, true]);
});

test.each(Object.values(PAGES))("%s is in the book's table of contents", (page) => {
  expect(readFileSync(book("SUMMARY"), "utf8")).toContain(`(${page}.md)`);
});

test("links lead to routes of the page or to https addresses", () => {
  const html = Object.values(PAGES).map(helpOf).join("\n");
  const targets = [...html.matchAll(/href="([^"]*)"/g)].map(([, href]) => href ?? "");
  expect(targets.length).toBeGreaterThan(3);
  for (const href of targets) expect(href).toMatch(/^(#\/[a-z]+|https:\/\/.+)$/);
  expect(html).not.toContain("<img");
});
