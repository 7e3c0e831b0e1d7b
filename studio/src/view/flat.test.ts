import { expect, test } from "vitest";
import { boundsOf, pathOf } from "./flat";

test("bounds are those of the points, with room", () => {
  expect(
    boundsOf([
      [1, -2],
      [4, 8],
    ]),
  ).toEqual({ x: 1, y: -2, width: 3, height: 10 });
  expect(
    boundsOf(
      [
        [1, -2],
        [4, 8],
      ],
      5,
    ),
  ).toEqual({ x: -4, y: -7, width: 13, height: 20 });
  expect(boundsOf([[3, 3]])).toEqual({ x: 3, y: 3, width: 0, height: 0 });
  expect(boundsOf([])).toEqual({ x: 0, y: 0, width: 0, height: 0 });
});

test("a point is a line that can be seen", () => {
  expect(pathOf([[1, 2]])).toBe("M1 2h0");
  expect(
    pathOf([
      [1, 2],
      [3, 4],
    ]),
  ).toBe("M1 2L3 4");
});
