// Rows that pick an object up and put it on another: positions of the tool, its actions, and waits.
import type { World } from "../view/world";
import type { Row } from "./rows";

export type WorldObject = World["objects"][number];
export type Grip = "suction" | "gripper";

/**
 * Height above an object at which the tool approaches and leaves it, mm. A carried object clears
 * others of up to this height.
 */
export const CLEARANCE = 40;

/** Tool that can pick; null for the others. */
export const gripOf = (tool: string | null | undefined): Grip | null =>
  tool === "suction" || tool === "gripper" ? tool : null;

/** Tip position for holding an object: the cup on its top, the fingers at half its height. */
export function gripPosition({ at: [x = 0, y = 0, z = 0], size }: WorldObject, grip: Grip): [number, number, number] {
  const height = size[2] ?? 0;
  return [x, y, z + (grip === "suction" ? height : height / 2)];
}

const rounded = (value: number) => Math.round(value * 100) / 100;
const point = ([x, y, z]: readonly number[], r: number) => [x, y, z, r].map((value) => rounded(value ?? 0));

/** Action of a tool at a row, with the wait that it needs. */
export function toolAction(grip: Grip, takes: boolean, wait: number): Pick<Row, "gripper" | "suction" | "wait"> {
  const held = wait > 0 ? wait : null;
  return grip === "suction"
    ? { suction: takes, gripper: null, wait: held }
    : { suction: null, gripper: takes ? "close" : "open", wait: held };
}

/** Names of rows. The row that picks has the name of its object, by which it is found again. */
export interface RowNames {
  above: (name: string) => string;
  on: (name: string) => string;
}

function rowsAt(
  [name, over]: readonly [string, string],
  place: readonly number[],
  r: number,
  act: Pick<Row, "gripper" | "suction" | "wait">,
): Row[] {
  const above = point([place[0] ?? 0, place[1] ?? 0, (place[2] ?? 0) + CLEARANCE], r);
  const idle = { gripper: null, suction: null, wait: null };
  return [
    { name: over, motion: { move: above, by: "joints" }, ...idle },
    { name, motion: { move: point(place, r), by: "line" }, ...act },
    { name: over, motion: { move: above, by: "line" }, ...idle },
  ];
}

/** Rows that pick an object up. An open gripper is lowered over it. */
export function pickRows(thing: WorldObject, grip: Grip, wait: number, r: number, names: RowNames): Row[] {
  const { name } = thing;
  const rows = rowsAt([name, names.above(name)], gripPosition(thing, grip), r, toolAction(grip, true, wait));
  const [first, ...rest] = rows;
  return first === undefined || grip === "suction" ? rows : [{ ...first, gripper: "open" }, ...rest];
}

/**
 * Rows that put the held object on another: higher by the part of the held object that is below the
 * tip.
 */
export function placeRows(
  on: WorldObject,
  held: WorldObject,
  grip: Grip,
  wait: number,
  r: number,
  names: RowNames,
): Row[] {
  const [x = 0, y = 0, z = 0] = on.at;
  const [, , hold] = gripPosition(held, grip);
  const place = [x, y, z + (on.size[2] ?? 0) + hold - (held.at[2] ?? 0)];
  return rowsAt([names.on(on.name), names.above(on.name)], place, r, toolAction(grip, false, wait));
}

const isPick = (row: Row): boolean => row.suction === true || row.gripper === "close";
const isRelease = (row: Row): boolean => row.suction === false || row.gripper === "open" || row.gripper === "off";

/**
 * Object held after a row: that of the last row so far that picks one, otherwise that in the world.
 */
export function heldAfter(rows: readonly Row[], nth: number, things: readonly WorldObject[]): WorldObject | null {
  for (const row of rows.slice(0, nth + 1).toReversed()) {
    if (isPick(row)) return things.find(({ name }) => name === row.name) ?? null;
    if (isRelease(row)) return null;
  }
  return things.find(({ held }) => held) ?? null;
}
