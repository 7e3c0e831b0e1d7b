// Objects on a sheet, and their composition into one drawing.
import type { Report } from "../api";
import { boundsOf, type Points } from "../view/flat";
import type { Shape } from "./shapes";
import type { Source, Values } from "./workshop";

export interface Place {
  at: [x: number, y: number];
  /** Scale relative to the true size. */
  scale: number;
  /** Rotation counter-clockwise as the reader sees it, degrees; 0 is upright. */
  turn: number;
}
export type Point = readonly [x: number, y: number];

/** Object on the sheet. */
export interface Item {
  id: number;
  /** Content with its format. */
  source: Source;
  format: string;
  /** Name for the user. */
  name: string;
  shape?: Shape;
  /** Colour of its pen; null for its own colours. */
  color: string | null;
  /** Options of the object: text, image, fill, and the parts to draw. */
  values: Values;
  /** True if none of its colours is drawn; the object stays on the sheet. */
  isOff?: boolean;
  /** Chosen place; null to place it where there is room. */
  place: Place | null;
}

export interface Doc {
  items: readonly Item[];
  /** Id of the selected object. */
  chosen: number | null;
}

export const selectedItem = ({ items, chosen }: Doc): Item | null => items.find(({ id }) => id === chosen) ?? null;
export const withChange = (doc: Doc, id: number, by: Partial<Item>): Doc => ({
  ...doc,
  items: doc.items.map((item) => (item.id === id ? { ...item, ...by } : item)),
});
export const withoutItem = (doc: Doc, id: number): Doc => {
  const at = doc.items.findIndex((item) => item.id === id);
  const items = doc.items.filter((item) => item.id !== id);
  return { items, chosen: (items[Math.min(at, items.length - 1)] ?? null)?.id ?? null };
};
/** Moves an object by this many places in the drawing order. */
export const withMovedItem = (doc: Doc, id: number, by: number): Doc => {
  const from = doc.items.findIndex((item) => item.id === id);
  const to = from + by;
  const item = doc.items[from];
  if (item === undefined || to < 0 || to >= doc.items.length) return doc;
  return { ...doc, items: doc.items.toSpliced(from, 1).toSpliced(to, 0, item) };
};

/** Option groups that belong to an object instead of the job. */
const OBJECT_GROUPS = ["fill", "text", "image"];
/** Options that divide an object into parts and select them. */
const PART_OPTIONS = ["only", "parts"];
export const isObjectOption = ({ group, name }: { group: string; name: string }): boolean =>
  OBJECT_GROUPS.includes(group) || PART_OPTIONS.includes(name);
/** Options that are valid for one object only: its parts. */
export const partsOf = (values: Values): Values =>
  Object.fromEntries(Object.entries(values).filter(([name]) => PART_OPTIONS.includes(name)));
/** Options that another object of the same format can take over. */
export const styleOf = (values: Values): Values =>
  Object.fromEntries(Object.entries(values).filter(([name]) => !PART_OPTIONS.includes(name) && name !== "crop"));

/** Objects to draw; all if all are switched off. */
export const drawnItems = (items: readonly Item[]): readonly Item[] => {
  const on = items.filter(({ isOff }) => isOff !== true);
  return on.length > 0 ? on : items;
};

const rounded = (value: number, digits: number) => Math.round(value * 10 ** digits) / 10 ** digits;
/** Equivalent rotation closest to 0. */
export const normalizedTurn = (turn: number): number => turn - 360 * Math.round(turn / 360);
/** Place with the precision that is sent to the station. */
export const roundedPlace = ({ at, scale, turn }: Place): Place => ({
  at: [rounded(at[0], 2), rounded(at[1], 2)],
  scale: Number(scale.toPrecision(6)),
  turn: rounded(normalizedTurn(turn), 2),
});
/** Limits of an object's longer side, and largest distance of its place along x or y, mm. */
const [MIN_SIDE, MAX_SIDE, MAX_DISTANCE] = [0.5, 2000, 2000];
/** Limits of the scale of an object whose size is unknown. */
const SCALE_RANGE = [1e-3, 1e3] as const;
const clamp = (value: number, [least, most]: readonly [number, number]) => Math.min(most, Math.max(least, value));
/**
 * Clamps a place so that the object remains visible, and can be grabbed and resized. `longest` is
 * its longer side at scale 1, mm.
 */
export function clampedPlace({ at, scale, turn }: Place, longest: number): Place {
  const far = (value: number) => clamp(value, [-MAX_DISTANCE, MAX_DISTANCE]);
  const scales = longest > 0 ? ([MIN_SIDE / longest, MAX_SIDE / longest] as const) : SCALE_RANGE;
  return { at: [far(at[0]), far(at[1])], scale: clamp(scale, scales), turn };
}
/** True if two places are equal within the station's rounding. */
export const isSame = (one: Place, other: Place): boolean =>
  Math.hypot(one.at[0] - other.at[0], one.at[1] - other.at[1]) < 0.05 &&
  Math.abs(one.scale / other.scale - 1) < 0.005 &&
  Math.abs(normalizedTurn(one.turn - other.turn)) < 0.05;

export function rotated([x, y]: readonly number[], degrees: number): [number, number] {
  const [cos, sin] = [Math.cos((degrees * Math.PI) / 180), Math.sin((degrees * Math.PI) / 180)];
  return [(x ?? 0) * cos - (y ?? 0) * sin, (x ?? 0) * sin + (y ?? 0) * cos];
}

type Stroke = NonNullable<Report["preview"]>["strokes"][number];
/**
 * Bounding box of strokes in axes rotated by `angle` from the arm's x, degrees: its sides, and its
 * middle relative to the place of the strokes.
 */
export function boxOf(strokes: readonly Stroke[], angle: number, [x, y]: Point): { sides: Point; middle: Point } {
  const box = boundsOf(
    strokes.flatMap(({ points }) => points.map(([px = 0, py = 0]) => rotated([px - x, py - y], -angle))),
  );
  return { sides: [box.width, box.height], middle: [box.x + box.width / 2, box.y + box.height / 2] };
}

/** Lines of one colour, in the arm's coordinates. */
export interface ColorLines {
  color: string;
  strokes: readonly Points[];
}
/** Lines of an object by colour: that of its pen, otherwise those of its parts. */
export function linesByColor({ parts, preview }: Report, color: string | null): ColorLines[] {
  const colors = new Map(parts.map((part) => [part.n, part.color]));
  const all = new Map<string, Points[]>();
  for (const { part, points } of preview?.strokes ?? []) {
    const colorKey = color ?? (part === null ? null : colors.get(part)) ?? "#000000";
    all.set(colorKey, [...(all.get(colorKey) ?? []), points]);
  }
  return [...all].map(([color, strokes]) => ({ color, strokes }));
}

/** Row of the table of parts: a part of a single object, or a colour of all objects. */
export interface PartRow {
  name: string | null;
  color: string | null;
  drawn_mm: number;
  seconds: number | null;
  isDrawn: boolean;
  /** Parts of objects that the row stands for; `n` is null for a whole object. */
  targets: ReadonlyArray<{ id: number; n: number | null }>;
}
type Reports = ReadonlyMap<number, { report: Report }>;

const isDrawn = (item: Item, { n, skipped }: Report["parts"][number]): boolean =>
  item.values.only ? item.values.only.split("\n").includes(String(n)) : !skipped;

/**
 * Rows for the parts of all objects on the sheet, drawn or not. `compositionReport` is the check of
 * all objects as one drawing; null for a single object.
 */
export function partRows(items: readonly Item[], reports: Reports, compositionReport: Report | null): PartRow[] {
  const drawn = drawnItems(items);
  const single = items.flatMap((item): PartRow[] => {
    const parts = reports.get(item.id)?.report.parts ?? [];
    const isOn = drawn.includes(item);
    if (compositionReport !== null && (item.color !== null || parts.length === 0)) {
      const color = item.color ?? "#000000";
      const length = parts.reduce((sum, { drawn_mm }) => sum + drawn_mm, 0);
      return [
        { name: null, color, drawn_mm: length, seconds: null, isDrawn: isOn, targets: [{ id: item.id, n: null }] },
      ];
    }
    return parts.map((part) => ({
      name: part.name,
      color: part.color,
      drawn_mm: part.drawn_mm,
      seconds: part.seconds,
      isDrawn: isOn && isDrawn(item, part),
      targets: [{ id: item.id, n: part.n }],
    }));
  });
  if (compositionReport === null) return single;
  const rows = new Map<string, PartRow>();
  for (const one of single) {
    const color = one.color ?? "#000000";
    const row = rows.get(color);
    const targets = [...(row?.targets ?? []), ...one.targets];
    const drawn_mm = one.drawn_mm + (row?.drawn_mm ?? 0);
    rows.set(color, {
      ...one,
      color,
      name: null,
      seconds: null,
      isDrawn: one.isDrawn || row?.isDrawn === true,
      drawn_mm,
      targets,
    });
  }
  // Durations are known only for colours that are drawn.
  return [...rows.values()].map((row) => {
    const part = row.isDrawn ? compositionReport.parts.find(({ color }) => color === row.color) : undefined;
    return part === undefined ? row : { ...row, drawn_mm: part.drawn_mm, seconds: part.seconds };
  });
}

/** Switches the part of a row on or off in every object that has it. */
export function withPartDrawn(doc: Doc, reports: Reports, row: PartRow, isOn: boolean, isComposed: boolean): Doc {
  const drawn = drawnItems(doc.items);
  const items = doc.items.map((item) => {
    const mine = row.targets.filter(({ id }) => id === item.id).map(({ n }) => n);
    if (mine.length === 0) return item;
    if (mine.includes(null)) return { ...item, isOff: !isOn };
    const parts = reports.get(item.id)?.report.parts ?? [];
    const was = drawn.includes(item) ? parts.filter((part) => isDrawn(item, part)).map(({ n }) => n) : [];
    const only = parts.map(({ n }) => n).filter((n) => (mine.includes(n) ? isOn : was.includes(n)));
    if (only.length === 0) return { ...item, isOff: true };
    const { only: _, ...values } = item.values;
    if (only.length === parts.length && parts.every(({ skipped }) => !skipped || item.values.only))
      return { ...item, isOff: false, values };
    // In a composition every object is checked by colour, so part numbers are numbers of colours.
    const kind = isComposed && !item.values.only ? { parts: "color" } : {};
    return { ...item, isOff: false, values: { ...values, ...kind, only: only.join("\n") } };
  });
  return { ...doc, items };
}

/** Composes lines in the arm's coordinates into one drawing in mm. Returns it with its middle. */
export function compose(inks: readonly ColorLines[]): { text: string; at: [number, number] } {
  const { x, y, width, height } = boundsOf(inks.flatMap(({ strokes }) => strokes.flat()));
  const short = (value: number) => String(rounded(value, 2));
  const data = (points: Points) => {
    const [first, ...rest] = points.map(([px = 0, py = 0]) => `${short(px - x)} ${short(y + height - py)}`);
    return `M${first}${rest.length === 0 ? "h0.01" : `L${rest.join(" ")}`}`;
  };
  const paths = inks.map(({ color, strokes }) => `<path stroke="${color}" d="${strokes.map(data).join("")}"/>`);
  const [wide, high] = [width, height].map((side) => short(Math.max(side, 0.01)));
  const size = `width="${wide}mm" height="${high}mm" viewBox="0 0 ${wide} ${high}"`;
  return {
    text: `<svg xmlns="http://www.w3.org/2000/svg" ${size}><g fill="none">${paths.join("")}</g></svg>`,
    at: [rounded(x + width / 2, 3), rounded(y + height / 2, 3)],
  };
}
