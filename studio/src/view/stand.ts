// Height at which the arm is drawn. A pose describes the tip, but for all of the vendor's tools,
// whose bias has no z, the pose's z is the height of the wrist's axis: a tip on the table reports a
// height far above the underside of the base. The picture therefore raises the arm until its base
// stands on the table, and lengthens the tool by the same amount, so that the tip remains at the
// pose.
import { USUAL_TABLE } from "./layers";
import type { Point } from "./solid";

/**
 * Distance from the base's underside up to the surface of the work, mm: the thickness of a sheet.
 */
const SHEET = 2;
/** Shortest and longest tool in the picture, mm. */
const TOOL = [48, 110] as const;

export interface Stand {
  /** Distance by which the arm is raised, mm. */
  lift: number;
  /** Height of the base's underside, mm. */
  floor: number;
  /** Height of the surface that the tip works on, mm. */
  surface: number;
}

/**
 * Computes the stand of an arm. `shoulder` is its height above the base's underside, `zBias` the
 * tool's own offset below the wrist.
 */
export function standOn(table: number | null, shoulder: number, zBias = 0): Stand {
  const surface = table ?? USUAL_TABLE;
  const [least, most] = TOOL;
  const lift = Math.min(most - zBias, Math.max(least - zBias, 0, surface + shoulder - SHEET));
  return { lift, floor: Math.min(lift - shoulder, surface - SHEET), surface };
}

/** Object under another one: its footprint and the height of its top. */
export interface Support {
  at: readonly number[];
  size: readonly number[];
  turn?: number;
  top: number;
}

/** Height of the highest surface below a point. */
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
