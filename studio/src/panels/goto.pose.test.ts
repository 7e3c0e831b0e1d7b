import { expect, test } from "vitest";
import { parseNumber } from "../numbers";
import { formatPose, parsePose } from "./goto.pose";

test("a pose is copied with two digits and no minus before a zero", () => {
  expect(formatPose({ x: 259.104, y: -0.001, z: -8.485, r: 30 })).toBe("259.1, 0, -8.48, 30");
});

test.each([
  ["220, -40, 10, 0", [220, -40, 10, 0]],
  ["220 -40 10", [220, -40, 10]],
  ["(x: 220; y: −40; z: .5; r = 90)", [220, -40, 0.5, 90]],
  ["[220.5,40]", [220.5, 40]],
  ['{"x":220,"y":-40,"z":10,"r":0}', [220, -40, 10, 0]],
])("%s is pasted as a pose", (text, pose) => {
  expect(parsePose(text)).toEqual(pose);
});

test.each(["220", "", "hello", "1 2 3 4 5 6"])("%s is no pose", (text) => {
  expect(parsePose(text)).toBeNull();
});

test("a copied pose is pasted unchanged", () => {
  expect(parsePose(formatPose({ x: 1.5, y: -2, z: 0, r: -179.99 }))).toEqual([1.5, -2, 0, -179.99]);
});

test("a pose accepts decimal points and commas, and no other text", () => {
  expect(parseNumber(" 12,5 ")).toBe(12.5);
  expect(parseNumber("−3")).toBe(-3);
  for (const text of ["", "-", "1e3", "12a", "1 2"]) expect(parseNumber(text)).toBeNull();
});
