import { expect, test } from "vitest";
import type { Report } from "../api";
import { bounded, boxOf, changed, composed, type Doc, type Item, inked, isSame, moved, tidy, without } from "./items";
import { SHAPES, svgOf } from "./shapes";

const item = (id: number): Item => ({
  id,
  source: { text: "x", format: "text" },
  format: "text",
  name: `${id}`,
  color: null,
  values: {},
  place: null,
});
const doc: Doc = { items: [1, 2, 3].map(item), chosen: 2 };
const ids = ({ items }: Doc) => items.map(({ id }) => id);

test("an object is changed, removed and drawn earlier without touching the others", () => {
  expect(changed(doc, 2, { color: "#ff0000" }).items.map(({ color }) => color)).toEqual([null, "#ff0000", null]);
  expect(without(doc, 2)).toMatchObject({ chosen: 3 });
  expect(without(without(without(doc, 1), 2), 3)).toEqual({ items: [], chosen: null });
  expect(ids(moved(doc, 3, -1))).toEqual([1, 3, 2]);
  expect(moved(doc, 1, -1)).toBe(doc);
});

test("a place is said as near as the station answers it", () => {
  const place = tidy({ at: [200.123, 0.004], scale: 1.23456789, turn: 450 });
  expect(place).toEqual({ at: [200.12, 0], scale: 1.23457, turn: 90 });
  expect(isSame(place, { at: [200.1, 0], scale: 1.2345, turn: 450 })).toBe(true);
  expect(isSame(place, { at: [201, 0], scale: 1.2345, turn: 90 })).toBe(false);
});

const stroke = (points: number[][], part: number | null = null) => ({
  points: points as [number, number][],
  part,
  height: -60,
  reachable: true,
  power: 100,
});
test("an upright drawing is as wide as it is along the arm's y", () => {
  const { sides, middle } = boxOf(
    [
      stroke([
        [200, -40],
        [220, 40],
      ]),
    ],
    90,
    [215, 0],
  );
  expect(sides[0]).toBeCloseTo(80);
  expect(sides[1]).toBeCloseTo(20);
  // Its middle is 5 mm nearer to the arm than its place: above it.
  expect(middle[0]).toBeCloseTo(0);
  expect(middle[1]).toBeCloseTo(5);
});

test("a drawing of all objects lies in true size where they lie", () => {
  const { text, at } = composed([
    {
      color: "#c81e1e",
      strokes: [
        [
          [200, -40],
          [220, 40],
        ],
      ],
    },
    { color: "#000000", strokes: [[[210, 0]]] },
  ]);
  expect(at).toEqual([210, 0]);
  expect(text).toContain('width="20mm" height="80mm" viewBox="0 0 20 80"');
  // The arm's +y is up in the file: its option rotate is 0 then.
  expect(text).toContain('<path stroke="#c81e1e" d="M0 80L20 0"/>');
  expect(text).toContain('d="M10 40h0.01"');
});

test("the pen of an object goes before the colours of its parts", () => {
  const report = {
    parts: [{ n: 1, color: "#0030b0" }],
    preview: {
      strokes: [
        stroke(
          [
            [0, 0],
            [1, 0],
          ],
          1,
        ),
        stroke([
          [0, 0],
          [0, 1],
        ]),
      ],
      travels: [],
    },
  } as unknown as Report;
  expect(inked(report, null).map(({ color }) => color)).toEqual(["#0030b0", "#000000"]);
  expect(inked(report, "#15803d").map(({ color }) => color)).toEqual(["#15803d"]);
});

test("every shape is a drawing in millimetres", () => {
  for (const shape of SHAPES) expect(svgOf(shape)).toMatch(/width="50mm" height="50mm".*<path d="M[\d.]/);
});

test("an object can be made neither too small to be seen nor too large to be taken hold of", () => {
  const place = { at: [200, 0] as [number, number], scale: 1, turn: 0 };
  expect(bounded({ ...place, scale: 1e-30 }, 100).scale * 100).toBeCloseTo(0.5);
  expect(bounded({ ...place, scale: 1e28 }, 100).scale * 100).toBeCloseTo(2000);
  expect(bounded({ ...place, scale: 0 }, 0).scale).toBeGreaterThan(0);
  expect(bounded({ ...place, scale: -1 }, 100).scale).toBeGreaterThan(0);
  expect(bounded({ ...place, at: [1e308, -1e308] }, 100).at).toEqual([2000, -2000]);
  expect(bounded(place, 100)).toEqual(place);
});
