import { expect, test } from "vitest";
import { numberOf, numbersOf } from "./numbers";

test("a number may have a decimal point or comma", () => {
  for (const [text, value] of [
    ["7,5", 7.5],
    ["7.5", 7.5],
    [" 12 ", 12],
    ["−5", -5],
    ["+.5", 0.5],
  ] as const)
    expect(numberOf(text)).toBe(value);
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
    expect(numberOf(text)).toBeNull();
});

test("several numbers are separated by spaces, commas or semicolons", () => {
  expect(numbersOf("2,2", 2)).toEqual([2, 2]);
  expect(numbersOf("2, 2", 2)).toEqual([2, 2]);
  expect(numbersOf("0,5 1,5", 2)).toEqual([0.5, 1.5]);
  expect(numbersOf("0,5; 1,5", 2)).toEqual([0.5, 1.5]);
  expect(numbersOf("200 -10 5.5", 3)).toEqual([200, -10, 5.5]);
  expect(numbersOf("200, -10, 5.5", 3)).toEqual([200, -10, 5.5]);
  for (const text of ["", "1", "1 2 3", "a b", "1 2mm"]) expect(numbersOf(text, 2)).toBeNull();
});
