import { expect, test } from "vitest";
import { directionOf, opacityOf, placeOf, VIEWS } from "./camera";
import type { Point } from "./solid";

const BOX: Point[] = [0, 1, 2, 3, 4, 5, 6, 7].map((nth) => [
  nth & 1 ? 320 : -80,
  nth & 2 ? 150 : -150,
  nth & 4 ? 200 : -60,
]);
const minus = (a: Point, b: Point): Point => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const dot = (a: Point, b: Point) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** Position of points in the picture: -1 to 1 from left to right, and from bottom to top. */
function seen(points: readonly Point[], direction: Point, aspect: number, covered = 0) {
  const { position } = placeOf(points, direction, 32, aspect, covered);
  const flat = Math.hypot(direction[0], direction[1]);
  const right: Point = [-direction[1] / flat, direction[0] / flat, 0];
  const up: Point = [-direction[2] * right[1], direction[2] * right[0], flat];
  const tan = Math.tan((16 * Math.PI) / 180);
  return points.map((point) => {
    const from = minus(point, position);
    const away = -dot(from, direction);
    return [dot(from, right) / (away * tan * aspect), dot(from, up) / (away * tan)] as const;
  });
}

test.each(VIEWS.flatMap((view) => [0.8, 1.3, 2.2].map((aspect) => [view, aspect] as const)))(
  "from the %s with aspect %d everything is in the picture, and it is filled",
  (view, aspect) => {
    const all = seen(BOX, directionOf(view), aspect).flat();
    expect(Math.max(...all.map(Math.abs))).toBeCloseTo(0.92, 3);
  },
);

test("no point lies in the part covered by buttons", () => {
  const heights = seen(BOX, directionOf("corner"), 2, 0.2).map(([, y]) => y);
  // The lower fifth of the picture is two fifths of its lower half.
  expect(Math.min(...heights)).toBeCloseTo(-0.92 * 0.6, 3);
  expect(Math.max(...heights)).toBeCloseTo(0.92, 3);
});

test("the reader is in front of the arm: +y is to the right, and from above the base is at the top", () => {
  for (const view of ["front", "top"] as const) {
    const [left, right] = seen(
      [
        [200, -100, 0],
        [200, 100, 0],
      ],
      directionOf(view),
      1,
    );
    expect(right?.[0]).toBeGreaterThan(left?.[0] ?? 1);
  }
  const [base, paper] = seen(
    [
      [0, 0, 0],
      [250, 0, 0],
    ],
    directionOf("top"),
    1,
  );
  expect(base?.[1]).toBeGreaterThan(paper?.[1] ?? 1);
});

test("the corner view is taken from the side of the work", () => {
  expect(directionOf("corner")[0]).toBeGreaterThan(0);
  expect(Math.sign(directionOf("corner", 120)[1])).toBe(-Math.sign(directionOf("corner", -120)[1]));
});

test("the arm is solid from the side and faint from above", () => {
  expect(opacityOf(30)).toBe(1);
  expect(opacityOf(90)).toBeLessThan(0.3);
  expect(opacityOf(68)).toBeLessThan(1);
});
