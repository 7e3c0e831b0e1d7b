// Rows that pick an object and put it on another: where the tool goes, what it does there, how long it waits.
import type { World } from "../view/seen";
import type { Row } from "./rows";

export type Thing = World["objects"][number];
export type Grip = "suction" | "gripper";

/** How far above an object the tool comes to it and leaves it: what it carries clears objects of this height, mm. */
export const CLEAR = 40;

/** The tool that picks, or null for one that cannot. */
export const gripOf = (tool: string | null | undefined): Grip | null =>
  tool === "suction" || tool === "gripper" ? tool : null;

/** Where the tip is to be to hold an object: the cup on its top, the fingers round its middle. */
export function holdOf({ at: [x = 0, y = 0, z = 0], size }: Thing, grip: Grip): [number, number, number] {
  const height = size[2] ?? 0;
  return [x, y, z + (grip === "suction" ? height : height / 2)];
}

const rounded = (value: number) => Math.round(value * 100) / 100;
const point = ([x, y, z]: readonly number[], r: number) => [x, y, z, r].map((value) => rounded(value ?? 0));

/** What a tool does at a row, with the time that it needs for it. */
export function acts(grip: Grip, takes: boolean, wait: number): Pick<Row, "gripper" | "suction" | "wait"> {
  const held = wait > 0 ? wait : null;
  return grip === "suction"
    ? { suction: takes, gripper: null, wait: held }
    : { suction: null, gripper: takes ? "close" : "open", wait: held };
}

/** How rows are called. The row that picks has the name of its object: by that it is found again. */
export interface Names {
  above: (name: string) => string;
  on: (name: string) => string;
}

function there(
  [name, over]: readonly [string, string],
  place: readonly number[],
  r: number,
  act: Pick<Row, "gripper" | "suction" | "wait">,
): Row[] {
  const above = point([place[0] ?? 0, place[1] ?? 0, (place[2] ?? 0) + CLEAR], r);
  const idle = { gripper: null, suction: null, wait: null };
  return [
    { name: over, motion: { move: above, by: "joints" }, ...idle },
    { name, motion: { move: point(place, r), by: "line" }, ...act },
    { name: over, motion: { move: above, by: "line" }, ...idle },
  ];
}

/** Picks an object up. An open gripper comes down over it. */
export function picks(thing: Thing, grip: Grip, wait: number, r: number, names: Names): Row[] {
  const { name } = thing;
  const rows = there([name, names.above(name)], holdOf(thing, grip), r, acts(grip, true, wait));
  const [first, ...rest] = rows;
  return first === undefined || grip === "suction" ? rows : [{ ...first, gripper: "open" }, ...rest];
}

/** Puts what is held on another object: by as much higher as what is held reaches below the tip. */
export function puts(on: Thing, held: Thing, grip: Grip, wait: number, r: number, names: Names): Row[] {
  const [x = 0, y = 0, z = 0] = on.at;
  const [, , hold] = holdOf(held, grip);
  const place = [x, y, z + (on.size[2] ?? 0) + hold - (held.at[2] ?? 0)];
  return there([names.on(on.name), names.above(on.name)], place, r, acts(grip, false, wait));
}

const takesAt = (row: Row): boolean => row.suction === true || row.gripper === "close";
const letsGoAt = (row: Row): boolean => row.suction === false || row.gripper === "open" || row.gripper === "off";

/** The object that is held behind a row: by the last row before it that picks one, else in the world. */
export function heldAfter(rows: readonly Row[], nth: number, things: readonly Thing[]): Thing | null {
  for (const row of rows.slice(0, nth + 1).toReversed()) {
    if (takesAt(row)) return things.find(({ name }) => name === row.name) ?? null;
    if (letsGoAt(row)) return null;
  }
  return things.find(({ held }) => held) ?? null;
}
