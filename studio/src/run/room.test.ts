import { expect, test } from "vitest";
import { clusters, freeSpot, isInside, type Room } from "./room";

/** Circle around the arm's base. */
const ring = (radius: number) =>
  Array.from({ length: 180 }, (_, nth) => [
    radius * Math.cos((nth * Math.PI) / 90),
    radius * Math.sin((nth * Math.PI) / 90),
  ]);
/** Reach as the station reports it: outer and inner outline. */
const outlines = [ring(315), ring(130)];
const paper = [
  [150, -150],
  [320, -150],
  [320, 150],
  [150, 150],
];
const room: Room = { outlines, paper, taken: [] };
const corners = ({ at: [x, y], scale }: { at: [number, number]; scale: number }, [w, h]: [number, number]) =>
  [-1, 1].flatMap((sx) => [-1, 1].map((sy) => [x + (sx * w * scale) / 2, y + (sy * h * scale) / 2]));

test("a name fills the width of the sheet within the reach", () => {
  // Size of a name along the arm's x and y. It is upright for the reader: its width is along y.
  const name: [number, number] = [10, 30];
  const spot = freeSpot(room, name, 1, Number.POSITIVE_INFINITY);
  expect(spot).not.toBeNull();
  if (spot === null) return;
  expect(spot.scale * 30).toBeGreaterThan(200);
  for (const [x = 0, y = 0] of corners(spot, name)) {
    expect(Math.hypot(x, y)).toBeLessThan(315);
    expect(isInside(paper, x, y)).toBe(true);
  }
});

test("the next object is placed clear of existing drawings", () => {
  const taken = [{ x: 190, y: -60, width: 90, height: 120 }];
  const side: [number, number] = [30, 30];
  const spot = freeSpot({ ...room, taken }, side, 1, 1);
  expect(spot?.scale).toBe(1);
  for (const [x = 0, y = 0] of corners(spot as { at: [number, number]; scale: number }, side))
    expect(x > 190 && x < 280 && y > -60 && y < 60).toBe(false);
});

test("a full sheet has no place", () => {
  const taken = [{ x: 100, y: -200, width: 300, height: 400 }];
  expect(freeSpot({ ...room, taken }, [30, 30], 0.3, 1)).toBeNull();
  expect(freeSpot({ outlines: [], paper: null, taken: [] }, [30, 30], 0.3, 1)).toBeNull();
});

test("without paper the object is placed in front of the base", () => {
  const spot = freeSpot({ outlines, paper: null, taken: [] }, [40, 40], 1, 1);
  expect(spot?.at[0]).toBeGreaterThan(110);
  expect(Math.abs(spot?.at[1] ?? Number.POSITIVE_INFINITY)).toBeLessThan(20);
});

test("the lines of a house are one drawing, and two houses are two", () => {
  const house = (x: number) => [
    [
      [x, 0],
      [x + 40, 0],
    ],
    [
      [x + 40, 2],
      [x + 40, 40],
    ],
    [
      [x, 38],
      [x, 3],
    ],
  ];
  expect(clusters(house(0))).toHaveLength(1);
  expect(clusters([...house(0), ...house(100)])).toHaveLength(2);
  // A large M and the i beside it are one name, though their distance is larger than small letters
  // are high.
  const name = [
    house(0)
      .flat()
      .map(([x = 0, y = 0]) => [2 * x, 3 * y]),
    [
      [120, 0],
      [120, 80],
    ],
  ];
  expect(clusters(name)).toEqual([{ x: 0, y: 0, width: 120, height: 120 }]);
  expect(clusters([])).toEqual([]);
});
