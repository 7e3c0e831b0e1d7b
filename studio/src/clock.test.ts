import { expect, test } from "vitest";
import { jumped, wallTime } from "./clock";
import { backend } from "./store";

const at = (time: number) => wallTime(time).getTime() / 1000;

test("what the page's arm said between two jumps was said as far ahead as its clock was then", () => {
  backend.value = "sim";
  jumped(1013, 13);
  jumped(1100, 26);
  jumped(1200, 23);
  expect([at(1000), at(1013), at(1050), at(1100), at(1199), at(1200), at(1300)]).toEqual([
    1000, 1000, 1037, 1074, 1173, 1177, 1277,
  ]);
});

test("another station's clock is the wall clock", () => {
  backend.value = "station";
  expect(at(1050.5)).toBe(1050.5);
});
