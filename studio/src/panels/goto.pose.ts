// A pose as people type, copy and paste it.
export const AXES = ["x", "y", "z", "r"] as const;
export type PoseValues = readonly [x: number, y: number, z: number, r: number];

const shown = (value: number) => String(Number(value.toFixed(2)) + 0);

/** `x, y, z, r` with two digits at most. */
export const poseText = (pose: Record<(typeof AXES)[number], number>): string =>
  AXES.map((axis) => shown(pose[axis])).join(", ");

/**
 * The values of a pasted pose, `null` where none is meant: two to five numbers, with or without names, units or
 * brackets; a fifth, the rail's, is left out. Numbers have a point: a comma parts them.
 */
export function poseOf(text: string): number[] | null {
  const plain = text.replaceAll("−", "-");
  // Not in "J1" or "mm2": a number follows no letter.
  const found = plain.match(/(?<![\w.])[+-]?(?:\d+\.?\d*|\.\d+)/g) ?? [];
  return found.length >= 2 && found.length <= 5 ? found.slice(0, 4).map(Number) : null;
}
