// How high the arm is drawn. A pose is the tip's, but its z is the height of the wrist's axis with every tool of the
// vendor's, whose bias has no z: a tip on the table reads a height far above the base's underside. So the picture lifts
// the arm until its base stands on the table, and hangs the tool from it by as much: the tip stays where the pose is.
import { USUAL_TABLE } from "./layers";
import type { Point } from "./solid";

/** The base stands so far below what lies on the table, mm: the thickness of a sheet. */
const SHEET = 2;
/** A tool is at least and at most so long in the picture, mm. */
const TOOL = [48, 110] as const;

export interface Stand {
  /** How far the arm is lifted, mm. */
  lift: number;
  /** Height of the base's underside, mm. */
  floor: number;
  /** Height of what the tip works on, mm. */
  surface: number;
}

/** `shoulder` is its height above the base's underside, `zBias` how far the tool's own bias leads below the wrist. */
export function standOn(table: number | null, shoulder: number, zBias = 0): Stand {
  const surface = table ?? USUAL_TABLE;
  const [least, most] = TOOL;
  const lift = Math.min(most - zBias, Math.max(least - zBias, 0, surface + shoulder - SHEET));
  return { lift, floor: Math.min(lift - shoulder, surface - SHEET), surface };
}

/** What stands under a thing: its footprint, and the height of its top. */
export interface Support {
  at: readonly number[];
  size: readonly number[];
  turn?: number;
  top: number;
}

/** Height of what is below a point. */
export function supportOf([x, y, z]: Point, supports: readonly Support[], floor: number): number {
  let highest = floor;
  for (const { at, size, turn = 0, top } of supports) {
    const angle = (-turn * Math.PI) / 180;
    const [dx, dy] = [x - (at[0] ?? 0), y - (at[1] ?? 0)];
    const [along, aside] = [dx * Math.cos(angle) - dy * Math.sin(angle), dx * Math.sin(angle) + dy * Math.cos(angle)];
    const isOver = Math.abs(along) <= (size[0] ?? 0) / 2 && Math.abs(aside) <= (size[1] ?? 0) / 2;
    if (isOver && top <= z + 1.5) highest = Math.max(highest, top);
  }
  return highest;
}
