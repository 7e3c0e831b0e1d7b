import { expect, test } from "vitest";
import { boundsOf, pathOf, ratioOf, toReader, viewBox } from "./flat";

/**
 * Position in the picture, right and down, that the transform READER gives to a position of the
 * arm.
 */
const seen = ([x = 0, y = 0]: readonly number[]) => [y, x];

test("the reader in front of the arm has +y to the right and the arm at the top", () => {
  const [base, near, left, right] = [
    [0, 0],
    [300, 0],
    [200, -50],
    [200, 50],
  ].map(seen);
  expect(base?.[1]).toBeLessThan(near?.[1] as number);
  expect(left?.[0]).toBeLessThan(right?.[0] as number);
});

test("a frame's width is along the arm's x, which runs down the picture", () => {
  const frame = boundsOf([
    [150, -150],
    [320, 150],
  ]);
  expect(frame).toEqual({ x: 150, y: -150, width: 170, height: 300 });
  expect(viewBox(frame)).toBe("-150 150 300 170");
  expect(ratioOf(frame)).toBeCloseTo(300 / 170);
});

test("a picture of the core is turned to the reader with its size", () => {
  const svg =
    '<svg xmlns="http://www.w3.org/2000/svg" width="30mm" height="10mm" viewBox="0 0 30 10"><path d="M0 10H30"/></svg>\n';
  const turned = toReader(svg);
  expect(turned).toContain('width="10mm" height="30mm" viewBox="0 0 10 30"');
  // The lower left corner becomes the upper left one.
  expect(turned).toContain('transform="matrix(0 1 -1 0 10 0)"');
  const at = ([x = 0, y = 0]) => [0 * x - 1 * y + 10, x];
  expect(at([0, 10])).toEqual([0, 0]);
  expect(at([30, 10])).toEqual([0, 30]);
  expect(turned.match(/<path/g)).toHaveLength(1);
});

test("text without a picture stays unchanged", () => {
  expect(toReader("")).toBe("");
  expect(toReader("<svg><path/></svg>")).toBe("<svg><path/></svg>");
});
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

test("a single point becomes a visible line", () => {
  expect(pathOf([[1, 2]])).toBe("M1 2h0");
  expect(
    pathOf([
      [1, 2],
      [3, 4],
    ]),
  ).toBe("M1 2L3 4");
});
