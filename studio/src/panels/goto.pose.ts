// Pose as text for typing, copying and pasting.
export const AXES = ["x", "y", "z", "r"] as const;
export type PoseValues = readonly [x: number, y: number, z: number, r: number];

const formatValue = (value: number) => String(Number(value.toFixed(2)) + 0);

/** Formats `x, y, z, r` with at most two decimals. */
export const formatPose = (pose: Record<(typeof AXES)[number], number>): string =>
  AXES.map((axis) => formatValue(pose[axis])).join(", ");

/**
 * Parses a pasted pose; `null` for other texts. Accepts two to five numbers, with or without
 * names, units and brackets. A fifth one, of the rail, is ignored. Decimals need a point, because
 * commas separate the numbers.
 */
export function parsePose(text: string): number[] | null {
  const plain = text.replaceAll("−", "-");
  // A number cannot follow a letter, as in "J1" or "mm2".
  const found = plain.match(/(?<![\w.])[+-]?(?:\d+\.?\d*|\.\d+)/g) ?? [];
  return found.length >= 2 && found.length <= 5 ? found.slice(0, 4).map(Number) : null;
}
