import { expect, test } from "vitest";
import { hasFills } from "./fills";

const svg = (inner: string, attributes = "") => `<svg xmlns="http://www.w3.org/2000/svg" ${attributes}>${inner}</svg>`;
const PATH = "M0 0H10V10Z";

test.each([
  ["a shape that says nothing is black", svg(`<path d="${PATH}"/>`), true],
  ["a fill of its own", svg(`<rect width="2" height="2" fill="#0030b0"/>`), true],
  ["a fill by its style", svg(`<circle r="2" style="stroke:none;fill: red"/>`), true],
  ["a fill by a class", svg(`<style>.a{fill:red}</style><path class="a" d="${PATH}"/>`, 'fill="none"'), true],
  ["a group that is filled", svg(`<g fill="green"><path d="${PATH}"/></g>`), true],
  ["lines alone", svg(`<path d="${PATH}" fill="none" stroke="#000"/>`), false],
  ["a group without fill", svg(`<g fill="none"><path d="${PATH}"/><g><rect width="1" height="1"/></g></g>`), false],
  ["white is the paper", svg(`<rect width="9" height="9" fill="#ffffff"/>`), false],
  ["what is only defined", svg(`<defs><path d="${PATH}"/></defs><path d="M0 0L5 5" stroke="red"/>`), false],
  ["a line of two points", svg(`<path d="M0 0L10 10" stroke="#000"/>`), false],
  ["a comment", svg(`<!-- <path d="${PATH}"/> -->`), false],
  ["no drawing", "", false],
])("%s", (_, text, is) => expect(hasFills(text)).toBe(is));
