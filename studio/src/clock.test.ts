import { expect, test } from "vitest";
import { recordJump, wallTime } from "./clock";
import { backend } from "./store";

const at = (time: number) => wallTime(time).getTime() / 1000;

test("a time between two jumps is converted by the offset of its jump", () => {
  backend.value = "sim";
  recordJump(1013, 13);
  recordJump(1100, 26);
  recordJump(1200, 23);
  expect([at(1000), at(1013), at(1050), at(1100), at(1199), at(1200), at(1300)]).toEqual([
    1000, 1000, 1037, 1074, 1173, 1177, 1277,
  ]);
});

test("another station's clock is the wall clock", () => {
  backend.value = "station";
  expect(at(1050.5)).toBe(1050.5);
});
