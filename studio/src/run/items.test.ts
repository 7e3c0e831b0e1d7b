import { expect, test } from "vitest";
import type { Report } from "../api";
import {
  boxOf,
  clampedPlace,
  compose,
  type Doc,
  drawnItems,
  type Item,
  isSame,
  linesByColor,
  partRows,
  roundedPlace,
  withChange,
  withMovedItem,
  withoutItem,
  withPartDrawn,
} from "./items";
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
  expect(withChange(doc, 2, { color: "#ff0000" }).items.map(({ color }) => color)).toEqual([null, "#ff0000", null]);
  expect(withoutItem(doc, 2)).toMatchObject({ chosen: 3 });
  expect(withoutItem(withoutItem(withoutItem(doc, 1), 2), 3)).toEqual({ items: [], chosen: null });
  expect(ids(withMovedItem(doc, 3, -1))).toEqual([1, 3, 2]);
  expect(withMovedItem(doc, 1, -1)).toBe(doc);
});

test("a place has the precision of the station", () => {
  const place = roundedPlace({ at: [200.123, 0.004], scale: 1.23456789, turn: 450 });
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
  // The item's middle is nearer to the arm than its position: above it.
  expect(middle[0]).toBeCloseTo(0);
  expect(middle[1]).toBeCloseTo(5);
});

test("a composition has the true size and place of its objects", () => {
  const { text, at } = compose([
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
  // The arm's +y points up in the file, because its option rotate is 0.
  expect(text).toContain('<path stroke="#c81e1e" d="M0 80L20 0"/>');
  expect(text).toContain('d="M10 40h0.01"');
});

test("the pen of an object overrides the colours of its parts", () => {
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
  expect(linesByColor(report, null).map(({ color }) => color)).toEqual(["#0030b0", "#000000"]);
  expect(linesByColor(report, "#15803d").map(({ color }) => color)).toEqual(["#15803d"]);
});

test("every shape is a drawing in millimetres", () => {
  for (const shape of SHAPES) expect(svgOf(shape)).toMatch(/width="50mm" height="50mm".*<path d="M[\d.]/);
});

test("the size of an object is clamped between visible and draggable", () => {
  const place = { at: [200, 0] as [number, number], scale: 1, turn: 0 };
  expect(clampedPlace({ ...place, scale: 1e-30 }, 100).scale * 100).toBeCloseTo(0.5);
  expect(clampedPlace({ ...place, scale: 1e28 }, 100).scale * 100).toBeCloseTo(2000);
  expect(clampedPlace({ ...place, scale: 0 }, 0).scale).toBeGreaterThan(0);
  expect(clampedPlace({ ...place, scale: -1 }, 100).scale).toBeGreaterThan(0);
  expect(clampedPlace({ ...place, at: [1e308, -1e308] }, 100).at).toEqual([2000, -2000]);
  expect(clampedPlace(place, 100)).toEqual(place);
});

const RED = { n: 1, name: null, color: "#d00000", strokes: 1, drawn_mm: 120, seconds: 10, skipped: false };
const BLUE = { ...RED, n: 2, color: "#2040ff", drawn_mm: 113 };
const reportOf = (parts: unknown[]) => ({ report: { parts } as unknown as Report });
const two = (id: number): Item => ({ ...item(id), format: "svg" });
const drawn = (doc: Doc, found: Parameters<typeof partRows>[1], together: Report | null) =>
  partRows(doc.items, found, together).map(({ color, isDrawn }) => [color, isDrawn]);

test("the drawn colours belong to the object: a copy has them, and another object does not change them", () => {
  const found = new Map([1, 2].map((id) => [id, reportOf([RED, BLUE])] as const));
  const alone: Doc = { items: [two(1)], chosen: 1 };
  const [red] = partRows(alone.items, found, null);
  const without = withPartDrawn(alone, found, red as never, false, false);
  expect(without.items[0]?.values).toEqual({ only: "2" });
  expect(drawn(without, found, null)).toEqual([
    ["#d00000", false],
    ["#2040ff", true],
  ]);
  // The object as it is now, twice: red stays out of both, and can be chosen again for both.
  const copied: Doc = { items: [...without.items, { ...(without.items[0] as Item), id: 2 }], chosen: 2 };
  const all = reportOf([BLUE]).report;
  expect(drawn(copied, found, all)).toEqual([
    ["#d00000", false],
    ["#2040ff", true],
  ]);
  const [again] = partRows(copied.items, found, all);
  expect(withPartDrawn(copied, found, again as never, true, true).items.map(({ values }) => values.only)).toEqual([
    undefined,
    undefined,
  ]);
  // Beside a text, which is black and has no parts.
  found.set(3, reportOf([]));
  const texted: Doc = { items: [...without.items, item(3)], chosen: 3 };
  expect(drawn(texted, found, all)).toEqual([
    ["#d00000", false],
    ["#2040ff", true],
    ["#000000", true],
  ]);
  const black = partRows(texted.items, found, all)[2];
  const noText = withPartDrawn(texted, found, black as never, false, true);
  expect(drawnItems(noText.items).map(({ id }) => id)).toEqual([1]);
  expect(drawn(noText, found, all).at(-1)).toEqual(["#000000", false]);
});

test("an object without drawn colours is not drawn, and is drawn again once a colour is ticked", () => {
  const found = new Map([1, 2].map((id) => [id, reportOf([RED])] as const));
  const doc: Doc = { items: [two(1), { ...two(2), color: "#15803d" }], chosen: 1 };
  const all = reportOf([RED]).report;
  const [red] = partRows(doc.items, found, all);
  const without = withPartDrawn(doc, found, red as never, false, true);
  expect(without.items.map(({ isOff }) => isOff === true)).toEqual([true, false]);
  const [off] = partRows(without.items, found, all);
  expect(drawnItems(withPartDrawn(without, found, off as never, true, true).items)).toHaveLength(2);
  // A choice of no colour counts as all colours.
  expect(drawnItems(doc.items.map((one) => ({ ...one, isOff: true })))).toHaveLength(2);
});
