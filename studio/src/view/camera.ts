// Camera position: the direction is given, the distance follows from the points that must be
// visible.
import type { Point } from "./solid";

export type View = "corner" | "front" | "side" | "top";
export const VIEWS: readonly View[] = ["corner", "front", "side", "top"];

/** Directions for a reader in front of the arm: +y is to the right, and from above -x is up. */
const FROM: Record<View, Point> = {
  corner: [0.74, -0.56, 0.56],
  front: [1, 0, 0.16],
  side: [0, -1, 0.16],
  top: [0.0008, 0, 1],
};
/** Share of the picture that is filled. The rest is a margin. */
const FILLED = 0.92;

export interface Place {
  position: Point;
  target: Point;
}

/**
 * Direction of a view. The corner view is taken from the side of the work if its mean `y` is
 * clearly off centre.
 */
export function directionOf(view: View, y = 0): Point {
  const [x, across, up] = FROM[view];
  const length = Math.hypot(x, across, up);
  const side = view === "corner" && y > 40 ? -1 : 1;
  return [x / length, (across * side) / length, up / length];
}

/**
 * Nearest position in a direction from which all points are in the picture. `fov` is its vertical
 * angle in degrees, `aspect` its width divided by its height, and `covered` the share at the bottom
 * that buttons hide. The target is at the mean depth of the points.
 */
export function placeOf(points: readonly Point[], direction: Point, fov: number, aspect: number, covered = 0): Place {
  const [dx, dy, dz] = direction;
  const flat = Math.hypot(dx, dy);
  const right: Point = [-dy / flat, dx / flat, 0];
  const up: Point = [-dz * right[1], dz * right[0], dx * right[1] - dy * right[0]];
  const dot = (a: Point, b: Point) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const tall = Math.tan((fov * Math.PI) / 360) * FILLED;
  // Along one axis of the picture: distance the camera needs, and its position as a function of
  // distance. The tangents are those of the frustum's two sides.
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

/**
 * Opacity of the arm, which hides its own drawing when seen from above: 1 from the side, low from
 * above.
 */
export function opacityOf(elevation: number): number {
  const [solid, faint] = [58, 78];
  const share = Math.min(1, Math.max(0, (elevation - solid) / (faint - solid)));
  return 1 - 0.78 * share;
}
