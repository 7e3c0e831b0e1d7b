// Objects on a sheet, and their composition into one drawing.
import type { Report } from "../api";
import { boundsOf, type Points } from "../view/flat";
import type { Shape } from "./shapes";
import type { Source, Values } from "./shop";

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
  /** Its own options: style of a text, processing of an image, fill of a shape. */
  values: Values;
  /** Chosen place; null to place it where there is room. */
  place: Place | null;
}

export interface Doc {
  items: readonly Item[];
  /** Id of the selected object. */
  chosen: number | null;
}

export const chosenOf = ({ items, chosen }: Doc): Item | null => items.find(({ id }) => id === chosen) ?? null;
export const changed = (doc: Doc, id: number, by: Partial<Item>): Doc => ({
  ...doc,
  items: doc.items.map((item) => (item.id === id ? { ...item, ...by } : item)),
});
export const without = (doc: Doc, id: number): Doc => {
  const at = doc.items.findIndex((item) => item.id === id);
  const items = doc.items.filter((item) => item.id !== id);
  return { items, chosen: (items[Math.min(at, items.length - 1)] ?? null)?.id ?? null };
};
/** Moves an object by this many places in the drawing order. */
export const moved = (doc: Doc, id: number, by: number): Doc => {
  const from = doc.items.findIndex((item) => item.id === id);
  const to = from + by;
  const item = doc.items[from];
  if (item === undefined || to < 0 || to >= doc.items.length) return doc;
  return { ...doc, items: doc.items.toSpliced(from, 1).toSpliced(to, 0, item) };
};

/** Option groups that belong to an object instead of the job. */
const OWN = ["fill", "text", "image"];
export const isOwn = ({ group }: { group: string }): boolean => OWN.includes(group);

const rounded = (value: number, digits: number) => Math.round(value * 10 ** digits) / 10 ** digits;
/** Equivalent rotation closest to 0. */
export const unwound = (turn: number): number => turn - 360 * Math.round(turn / 360);
/** Place with the precision that is sent to the station. */
export const tidy = ({ at, scale, turn }: Place): Place => ({
  at: [rounded(at[0], 2), rounded(at[1], 2)],
  scale: Number(scale.toPrecision(6)),
  turn: rounded(unwound(turn), 2),
});
/** True if two places are equal within the station's rounding. */
export const isSame = (one: Place, other: Place): boolean =>
  Math.hypot(one.at[0] - other.at[0], one.at[1] - other.at[1]) < 0.05 &&
  Math.abs(one.scale / other.scale - 1) < 0.005 &&
  Math.abs(unwound(one.turn - other.turn)) < 0.05;

export function turned([x, y]: readonly number[], degrees: number): [number, number] {
  const [cos, sin] = [Math.cos((degrees * Math.PI) / 180), Math.sin((degrees * Math.PI) / 180)];
  return [(x ?? 0) * cos - (y ?? 0) * sin, (x ?? 0) * sin + (y ?? 0) * cos];
}

type Stroke = NonNullable<Report["preview"]>["strokes"][number];
/**
 * Size of strokes at an angle from the arm's x and relative to their place, as the reader sees it.
 */
export function boxOf(strokes: readonly Stroke[], angle: number, [x, y]: Point): { sides: Point; middle: Point } {
  const box = boundsOf(
    strokes.flatMap(({ points }) => points.map(([px = 0, py = 0]) => turned([px - x, py - y], -angle))),
  );
  return { sides: [box.width, box.height], middle: [box.x + box.width / 2, box.y + box.height / 2] };
}

/** Lines of one colour, in the arm's coordinates. */
export interface Inked {
  color: string;
  strokes: readonly Points[];
}
/** Lines of an object by colour: that of its pen, otherwise those of its parts. */
export function inked({ parts, preview }: Report, color: string | null): Inked[] {
  const colors = new Map(parts.map((part) => [part.n, part.color]));
  const all = new Map<string, Points[]>();
  for (const { part, points } of preview?.strokes ?? []) {
    const of = color ?? (part === null ? null : colors.get(part)) ?? "#000000";
    all.set(of, [...(all.get(of) ?? []), points]);
  }
  return [...all].map(([color, strokes]) => ({ color, strokes }));
}

/** Composes lines in the arm's coordinates into one drawing in mm. Returns it with its middle. */
export function composed(inks: readonly Inked[]): { text: string; at: [number, number] } {
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
