// Points in the plane of the sheet, as pictures have them: X to the right, Y up.
export type Points = ReadonlyArray<readonly number[]>;

export interface Frame {
  x: number;
  y: number;
  width: number;
  height: number;
}

/** What points fill, with room round it. */
export function boundsOf(points: Points, room = 0): Frame {
  let [left, right, bottom, top] = [Infinity, -Infinity, Infinity, -Infinity];
  for (const [x = 0, y = 0] of points) {
    [left, right] = [Math.min(left, x), Math.max(right, x)];
    [bottom, top] = [Math.min(bottom, y), Math.max(top, y)];
  }
  if (left > right) return { x: 0, y: 0, width: 0, height: 0 };
  return { x: left - room, y: bottom - room, width: right - left + 2 * room, height: top - bottom + 2 * room };
}

/** A line as the data of a path; a point is a line of no length. */
export const pathOf = (points: Points): string =>
  `M${points.map(([x = 0, y = 0]) => `${x} ${y}`).join("L")}${points.length === 1 ? "h0" : ""}`;

/** In a picture with this frame Y is turned up by this transform. */
export const viewBox = ({ x, y, width, height }: Frame): string => `${x} ${-y - height} ${width} ${height}`;
export const UP = "scale(1 -1)";
