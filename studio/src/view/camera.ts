// Where the camera stands: the direction is chosen, the place follows from what has to be seen.
import type { Point } from "./solid";

export type View = "corner" | "front" | "side" | "top";
export const VIEWS: readonly View[] = ["corner", "front", "side", "top"];

/** The reader stands in front of the arm and looks at it: from there +y is to the right, and from above -x is up. */
const FROM: Record<View, Point> = {
  corner: [0.74, -0.56, 0.56],
  front: [1, 0, 0.16],
  side: [0, -1, 0.16],
  top: [0.0008, 0, 1],
};
/** Part of the picture that is filled: the rest is room at its rim. */
const FILLED = 0.92;

export interface Place {
  position: Point;
  target: Point;
}

/** The direction of a view: the corner is on the side of the work, `y` its middle, where that is clearly to one side. */
export function directionOf(view: View, y = 0): Point {
  const [x, across, up] = FROM[view];
  const length = Math.hypot(x, across, up);
  const side = view === "corner" && y > 40 ? -1 : 1;
  return [x / length, (across * side) / length, up / length];
}

/**
 * The nearest place in this direction from which all points are in the picture; `fov` is its height, degrees, and
 * `aspect` its width by its height. Of its lower part the share `covered` shows nothing: buttons lie over it. The target
 * is as far away as the middle of the points.
 */
export function placeOf(points: readonly Point[], direction: Point, fov: number, aspect: number, covered = 0): Place {
  const [dx, dy, dz] = direction;
  const flat = Math.hypot(dx, dy);
  const right: Point = [-dy / flat, dx / flat, 0];
  const up: Point = [-dz * right[1], dz * right[0], dx * right[1] - dy * right[0]];
  const dot = (a: Point, b: Point) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const tall = Math.tan((fov * Math.PI) / 360) * FILLED;
  // Along an axis of the picture: how far away the camera has to be, and where it is then. The tangents are those of the
  // picture's rims on the side of the axis and on the other.
  const span = (axis: Point, ahead: number, behind: number) => {
    let [most, least] = [-Infinity, -Infinity];
    for (const point of points) {
      const [at, away] = [dot(point, axis), -dot(point, direction)];
      most = Math.max(most, at - ahead * away);
      least = Math.max(least, -at - behind * away);
    }
    const middle = (away: number) => (most + ahead * away - least - behind * away) / 2;
    return { middle, away: -(most + least) / (ahead + behind) };
  };
  const across = span(right, tall * aspect, tall * aspect);
  const above = span(up, tall, tall * (1 - 2 * covered));
  const back = Math.min(across.away, above.away);
  const depths = points.map((point) => -dot(point, direction));
  const depth = (Math.min(...depths) + Math.max(...depths)) / 2;
  const [aside, high] = [across.middle(back), above.middle(back)];
  const at = (away: number): Point => [
    right[0] * aside + up[0] * high - dx * away,
    right[1] * aside + up[1] * high - dy * away,
    right[2] * aside + up[2] * high - dz * away,
  ];
  return { position: at(back), target: at(depth) };
}

/** How much of the arm is seen from above, where it hides what it draws: 1 from the side, little from above. */
export function opacityOf(elevation: number): number {
  const [solid, faint] = [58, 78];
  const share = Math.min(1, Math.max(0, (elevation - solid) / (faint - solid)));
  return 1 - 0.78 * share;
}
