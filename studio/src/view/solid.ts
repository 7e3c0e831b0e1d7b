// Solids for the pictures: triangles between convex outlines joined ring by ring. Three numbers per
// corner, mm.

export type Point = readonly [number, number, number];
/** Circle enclosed by an outline: centre and radius. */
export type Circle = readonly [x: number, y: number, radius: number];
/** Corners of a closed planar outline, counter-clockwise. */
type Outline = ReadonlyArray<readonly [number, number]>;
/** Plane of a plate, named by the two axes of its outline. Its thickness is along the third. */
export type PlatePlane = "xy" | "xz" | "yz";

/**
 * Number of corners of an outline, of a thin one, and of all outlines in a picture with many small
 * arms.
 */
const [CORNERS, THIN_CORNERS, FEW_CORNERS] = [32, 16, 10];
/** Largest radius of a thin part, mm. */
const THIN = 9.5;
let isCoarse = false;
const cornersOf = (radii: readonly number[]) =>
  isCoarse ? FEW_CORNERS : Math.max(...radii) < THIN ? THIN_CORNERS : CORNERS;
/** Angle between faces below which their edge is shaded smooth, degrees. */
const CREASE = 38;

/**
 * Convex hull of circles, like a belt around pulleys. Every outline has the same number of corners
 * in the same directions, so that two outlines can be joined. `inset` reduces the radii, for a
 * bevelled edge.
 */
function hull(circles: readonly Circle[], count: number, inset = 0): Outline {
  return Array.from({ length: count }, (_, nth) => {
    // Half a step off the axes, so that sides along the axes are straight.
    const angle = ((nth + 0.5) / count) * 2 * Math.PI;
    const [x, y] = [Math.cos(angle), Math.sin(angle)];
    let [most, found]: [number, readonly [number, number]] = [-Infinity, [0, 0]];
    for (const [cx, cy, radius] of circles) {
      const size = Math.max(0.01, radius - inset);
      const reach = cx * x + cy * y + size;
      if (reach > most + 1e-9) [most, found] = [reach, [cx + size * x, cy + size * y]];
    }
    return found;
  });
}

/** Builds solids with few corners, for pictures with many small arms. */
export function coarse<T>(make: () => T): T {
  isCoarse = true;
  try {
    return make();
  } finally {
    isCoarse = false;
  }
}

/** Surface between consecutive rings, closed at both ends. Its faces point outwards. */
export function loft(rings: ReadonlyArray<readonly Point[]>): number[] {
  const all: number[] = [];
  const face = (...corners: ReadonlyArray<Point | undefined>) => {
    for (const corner of corners) all.push(...(corner ?? [0, 0, 0]));
  };
  rings.forEach((ring, nth) => {
    const next = rings[nth + 1];
    const count = ring.length;
    for (let at = 0; at < count; at++) {
      const to = (at + 1) % count;
      if (next !== undefined) {
        face(ring[at], ring[to], next[to]);
        face(ring[at], next[to], next[at]);
      }
      if (nth === 0) face(middle(ring), ring[to], ring[at]);
      if (nth === rings.length - 1) face(middle(ring), ring[at], ring[to]);
    }
  });
  return volumeOf(all) < 0 ? reversed(all) : all;
}

function middle(ring: readonly Point[]): Point {
  const sum = ring.reduce(([x, y, z], point) => [x + point[0], y + point[1], z + point[2]] as const, [0, 0, 0]);
  return [sum[0] / ring.length, sum[1] / ring.length, sum[2] / ring.length];
}

/** Volume enclosed by triangles, mm³; negative if they point inwards. */
export function volumeOf(corners: readonly number[]): number {
  let six = 0;
  const at = (nth: number) => corners[nth] ?? 0;
  for (let n = 0; n < corners.length; n += 9) {
    six += at(n) * (at(n + 4) * at(n + 8) - at(n + 5) * at(n + 7));
    six += at(n + 1) * (at(n + 5) * at(n + 6) - at(n + 3) * at(n + 8));
    six += at(n + 2) * (at(n + 3) * at(n + 7) - at(n + 4) * at(n + 6));
  }
  return six / 6;
}

function reversed(corners: readonly number[]): number[] {
  const all: number[] = [];
  for (let at = 0; at < corners.length; at += 9)
    all.push(...corners.slice(at, at + 3), ...corners.slice(at + 6, at + 9), ...corners.slice(at + 3, at + 6));
  return all;
}

const PLATE_POINTS: Record<PlatePlane, (u: number, v: number, w: number) => Point> = {
  xy: (u, v, w) => [u, v, w],
  xz: (u, v, w) => [u, w, v],
  yz: (u, v, w) => [w, u, v],
};

/** Plate around circles of a plane, from `least` to `most` across it, with bevelled edges. */
export function plate(
  plane: PlatePlane,
  circles: readonly Circle[],
  least: number,
  most: number,
  bevel = 1.5,
): number[] {
  const place = PLATE_POINTS[plane];
  const count = cornersOf(circles.map(([, , radius]) => radius));
  const ring = (inset: number, w: number) => hull(circles, count, inset).map(([u, v]) => place(u, v, w));
  return loft([ring(bevel, least), ring(0, least + bevel), ring(0, most - bevel), ring(bevel, most)]);
}

/** Circles at the corners of a rectangle. */
export const corners = (left: number, right: number, low: number, high: number, radius: number): Circle[] => [
  [left + radius, low + radius, radius],
  [right - radius, low + radius, radius],
  [right - radius, high - radius, radius],
  [left + radius, high - radius, radius],
];

/** Box between two corners, with bevelled edges. */
export const box = (from: Point, to: Point, radius = 3, bevel = 1.2): number[] =>
  plate("xy", corners(from[0], to[0], from[1], to[1], radius), from[2], to[2], bevel);

/**
 * Body of revolution about z, or along y. `profile` lists radius and height from one end to the
 * other.
 */
export function lathe(profile: ReadonlyArray<readonly [radius: number, z: number]>, along: "z" | "y" = "z"): number[] {
  const place = PLATE_POINTS[along === "z" ? "xy" : "xz"];
  const count = cornersOf(profile.map(([radius]) => radius));
  return loft(profile.map(([radius, z]) => hull([[0, 0, radius]], count).map(([u, v]) => place(u, v, z))));
}

/** Hose along points, with rounded corners. */
export function tube(points: readonly Point[], radius: number): number[] {
  const path = smooth(smooth(points));
  let side: Point = [0, 1, 0];
  return loft(
    path.map((point, nth) => {
      const along = unit(minus(path[nth + 1] ?? point, path[nth - 1] ?? point));
      const across = unit(minus(side, times(along, dot(side, along))));
      side = across;
      const up = cross(along, across);
      return Array.from({ length: 10 }, (_, at): Point => {
        const [c, s] = [Math.cos((at / 5) * Math.PI) * radius, Math.sin((at / 5) * Math.PI) * radius];
        return [
          point[0] + across[0] * c + up[0] * s,
          point[1] + across[1] * c + up[1] * s,
          point[2] + across[2] * c + up[2] * s,
        ];
      });
    }),
  );
}

/** Cuts the corners of a path (Chaikin). Its ends remain. */
function smooth(points: readonly Point[]): Point[] {
  const [first, last] = [points[0], points[points.length - 1]];
  if (first === undefined || last === undefined) return [];
  const cut: Point[] = [first];
  for (let nth = 1; nth < points.length; nth++) {
    const [from, to] = [points[nth - 1] ?? first, points[nth] ?? last];
    const part = (share: number): Point => [
      from[0] + (to[0] - from[0]) * share,
      from[1] + (to[1] - from[1]) * share,
      from[2] + (to[2] - from[2]) * share,
    ];
    if (nth > 1) cut.push(part(0.25));
    if (nth < points.length - 1) cut.push(part(0.75));
  }
  return [...cut, last];
}

const dot = (a: Point, b: Point) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const minus = (a: Point, b: Point): Point => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const times = (a: Point, by: number): Point => [a[0] * by, a[1] * by, a[2] * by];
const cross = (a: Point, b: Point): Point => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];
const unit = (a: Point): Point => times(a, 1 / Math.max(1e-9, Math.sqrt(dot(a, a))));

export const moved = (all: readonly number[], by: Point): number[] =>
  all.map((value, nth) => value + (by[nth % 3] ?? 0));

/**
 * Tolerance for equal corners, mm, and largest coordinate in these steps: three rounded coordinates
 * then fit exactly into one number.
 */
const [EQUAL_TOLERANCE, MAX_STEPS] = [0.01, 50_000];

/** Normal for each corner: smooth across flat edges, and flat at creases. */
export function normalsOf(all: readonly number[]): Float32Array {
  const at = (nth: number): Point => [all[nth * 3] ?? 0, all[nth * 3 + 1] ?? 0, all[nth * 3 + 2] ?? 0];
  const count = all.length / 3;
  const faces: Point[] = [];
  const units: Point[] = [];
  const keys = new Float64Array(count);
  const places = new Map<number, number[]>();
  for (let nth = 0; nth < count; nth++) {
    if (nth % 3 === 0) {
      const face = cross(minus(at(nth + 1), at(nth)), minus(at(nth + 2), at(nth)));
      faces.push(face);
      units.push(unit(face));
    }
    let key = 0;
    for (let axis = 0; axis < 3; axis++)
      key = key * 2 * MAX_STEPS + Math.round((all[nth * 3 + axis] ?? 0) / EQUAL_TOLERANCE) + MAX_STEPS;
    keys[nth] = key;
    const there = places.get(key);
    if (there === undefined) places.set(key, [faces.length - 1]);
    else there.push(faces.length - 1);
  }
  const least = Math.cos((CREASE * Math.PI) / 180);
  const normals = new Float32Array(all.length);
  for (let nth = 0; nth < count; nth++) {
    const own = units[Math.floor(nth / 3)] ?? [0, 0, 1];
    let [x, y, z] = [0, 0, 0];
    for (const face of places.get(keys[nth] ?? 0) ?? []) {
      if (dot(own, units[face] ?? own) < least) continue;
      const area = faces[face] ?? own;
      x += area[0];
      y += area[1];
      z += area[2];
    }
    const length = Math.sqrt(x * x + y * y + z * z);
    normals.set(length < 1e-6 ? own : [x / length, y / length, z / length], nth * 3);
  }
  return normals;
}
