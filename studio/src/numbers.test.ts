import { expect, test } from "vitest";
import { parseNumber, parseNumbers } from "./numbers";

test("a number may have a decimal point or comma", () => {
  for (const [text, value] of [
    ["7,5", 7.5],
    ["7.5", 7.5],
    [" 12 ", 12],
    ["−5", -5],
    ["+.5", 0.5],
  ] as const)
    expect(parseNumber(text)).toBe(value);
});

test("text with trailing characters is not a number", () => {
  for (const text of [
    "",
    "abc",
    "30 40",
    "5mm",
    "1,2,3",
    "NaN",
    "Infinity",
    "1e309",
    "9".repeat(400),
    "0x10",
    "--5",
    "1e3",
    "9999999999",
  ])
    expect(parseNumber(text)).toBeNull();
});

test("several numbers are separated by spaces, commas or semicolons", () => {
  expect(parseNumbers("2,2", 2)).toEqual([2, 2]);
  expect(parseNumbers("2, 2", 2)).toEqual([2, 2]);
  expect(parseNumbers("0,5 1,5", 2)).toEqual([0.5, 1.5]);
  expect(parseNumbers("0,5; 1,5", 2)).toEqual([0.5, 1.5]);
  expect(parseNumbers("200 -10 5.5", 3)).toEqual([200, -10, 5.5]);
  expect(parseNumbers("200, -10, 5.5", 3)).toEqual([200, -10, 5.5]);
  for (const text of ["", "1", "1 2 3", "a b", "1 2mm"]) expect(parseNumbers(text, 2)).toBeNull();
});
