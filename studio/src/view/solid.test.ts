import { expect, test } from "vitest";
import { box, lathe, normalsOf, plate, tube, volumeOf } from "./solid";

test("a box has its volume and faces outwards", () => {
  const volume = volumeOf(box([-10, -20, 0], [10, 20, 30], 0.02, 0.01));
  expect(volume).toBeGreaterThan(20 * 40 * 30 * 0.99);
  expect(volume).toBeLessThan(20 * 40 * 30 * 1.001);
});

test.each(["xy", "xz", "yz"] as const)("a plate in the plane %s looks outwards, whatever its axes", (plane) => {
  const circles = [
    [0, 0, 10],
    [40, 0, 6],
  ] as const;
  expect(volumeOf(plate(plane, circles, -3, 3))).toBeGreaterThan(0);
});

test("a plate reaches the rims of its circles and its thickness", () => {
  const all = plate(
    "xz",
    [
      [0, 0, 10],
      [0, 100, 5],
    ],
    -4,
    4,
  );
  const span = (axis: number) => {
    const values = all.filter((_, nth) => nth % 3 === axis);
    return [Math.min(...values), Math.max(...values)];
  };
  expect(span(1)).toEqual([-4, 4]);
  expect(span(2)[0]).toBeCloseTo(-10, 0);
  expect(span(2)[1]).toBeCloseTo(105, 0);
});

test("a profile that goes down makes the same body as one that goes up", () => {
  const up = volumeOf(
    lathe([
      [5, 0],
      [5, 10],
    ]),
  );
  const down = volumeOf(
    lathe([
      [5, 10],
      [5, 0],
    ]),
  );
  expect(up).toBeCloseTo(down);
  expect(up / (Math.PI * 25 * 10)).toBeCloseTo(1, 1);
});

test("a hose keeps its ends and its thickness", () => {
  const all = tube(
    [
      [0, 0, 0],
      [0, 0, 50],
      [50, 0, 50],
    ],
    2,
  );
  const x = all.filter((_, nth) => nth % 3 === 0);
  const z = all.filter((_, nth) => nth % 3 === 2);
  expect(Math.max(...x)).toBeCloseTo(50);
  expect(Math.min(...z)).toBeCloseTo(0);
  expect(volumeOf(all)).toBeGreaterThan(0);
});

test("normals are round over a cylinder's skin and sharp at its end", () => {
  const all = lathe([
    [10, 0],
    [10, 20],
  ]);
  const normals = normalsOf(all);
  for (let nth = 0; nth < all.length; nth += 3) {
    const [x = 0, y = 0] = all.slice(nth, nth + 2);
    const [nx = 0, ny = 0, nz = 0] = normals.slice(nth, nth + 3);
    expect(Math.hypot(nx, ny, nz)).toBeCloseTo(1);
    // On the lateral surface the normal points away from the axis, on the ends along it.
    if (Math.abs(nz) < 0.5) expect((nx * x + ny * y) / Math.hypot(x, y)).toBeGreaterThan(0.99);
    else expect(Math.abs(nz)).toBeCloseTo(1);
  }
});
