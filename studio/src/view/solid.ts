// Solids of the pictures: triangles of convex outlines joined ring by ring, three numbers a corner, mm.

export type Point = readonly [number, number, number];
/** A circle that an outline goes round: its middle, and its radius. */
export type Circle = readonly [x: number, y: number, radius: number];
/** Corners of a closed outline in the plane, counter-clockwise. */
type Outline = ReadonlyArray<readonly [number, number]>;
/** The plane of a plate, by the two axes of its outline; its thickness is along the third. */
export type PlatePlane = "xy" | "xz" | "yz";

/** Corners of an outline, and of one that is small in its picture. */
const [CORNERS, FEW_CORNERS] = [32, 12];
let cornersNow = CORNERS;
/** Edges between faces that meet flatter than this are round, degrees. */
const CREASE = 38;

/**
 * The outline round circles, as a belt runs round pulleys. Every outline has as many corners, each in the same
 * direction, so that two can be joined; one of smaller radii is a bevelled edge.
 */
function hull(circles: readonly Circle[], inset = 0): Outline {
  return Array.from({ length: cornersNow }, (_, nth) => {
    // Half a step off the axes: sides along them are straight then.
    const angle = ((nth + 0.5) / cornersNow) * 2 * Math.PI;
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

/** What is made with few corners: each of many arms is small. */
export function coarse<T>(make: () => T): T {
  cornersNow = FEW_CORNERS;
  try {
    return make();
  } finally {
    cornersNow = CORNERS;
  }
}

/** The skin from one ring to the next, closed at both ends; its faces look outwards. */
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
  return volumeOf(all) < 0 ? turnedInside(all) : all;
}

function middle(ring: readonly Point[]): Point {
  const sum = ring.reduce(([x, y, z], point) => [x + point[0], y + point[1], z + point[2]] as const, [0, 0, 0]);
  return [sum[0] / ring.length, sum[1] / ring.length, sum[2] / ring.length];
}

/** What triangles enclose, mm3; negative where they look inwards. */
export function volumeOf(corners: readonly number[]): number {
  let six = 0;
  for (let at = 0; at < corners.length; at += 9) {
    const [ax = 0, ay = 0, az = 0, bx = 0, by = 0, bz = 0, cx = 0, cy = 0, cz = 0] = corners.slice(at, at + 9);
    six += ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx);
  }
  return six / 6;
}

function turnedInside(corners: readonly number[]): number[] {
  const all: number[] = [];
  for (let at = 0; at < corners.length; at += 9)
    all.push(...corners.slice(at, at + 3), ...corners.slice(at + 6, at + 9), ...corners.slice(at + 3, at + 6));
  return all;
}

const PLACES: Record<PlatePlane, (u: number, v: number, w: number) => Point> = {
  xy: (u, v, w) => [u, v, w],
  xz: (u, v, w) => [u, w, v],
  yz: (u, v, w) => [w, u, v],
};

/** A plate round circles of a plane, from `least` to `most` across it, with bevelled edges. */
export function plate(
  plane: PlatePlane,
  circles: readonly Circle[],
  least: number,
  most: number,
  bevel = 1.5,
): number[] {
  const place = PLACES[plane];
  const ring = (inset: number, w: number) => hull(circles, inset).map(([u, v]) => place(u, v, w));
  return loft([ring(bevel, least), ring(0, least + bevel), ring(0, most - bevel), ring(bevel, most)]);
}

/** Circles at the corners of a rectangle. */
export const corners = (left: number, right: number, low: number, high: number, radius: number): Circle[] => [
  [left + radius, low + radius, radius],
  [right - radius, low + radius, radius],
  [right - radius, high - radius, radius],
  [left + radius, high - radius, radius],
];

/** A box between two corners, with bevelled edges. */
export const box = (from: Point, to: Point, radius = 3, bevel = 1.2): number[] =>
  plate("xy", corners(from[0], to[0], from[1], to[1], radius), from[2], to[2], bevel);

/** A body of revolution about z, or along y; `profile` is radius and height from one end to the other. */
export function lathe(profile: ReadonlyArray<readonly [radius: number, z: number]>, along: "z" | "y" = "z"): number[] {
  const place = PLACES[along === "z" ? "xy" : "xz"];
  return loft(profile.map(([radius, z]) => hull([[0, 0, radius]]).map(([u, v]) => place(u, v, z))));
}

/** A hose along points, with corners cut round. */
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

/** Cuts corners off a path; its ends stay. */
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

/** A normal for each corner: round over flat edges, and sharp over the others. */
export function normalsOf(all: readonly number[]): Float32Array {
  const at = (nth: number): Point => [all[nth * 3] ?? 0, all[nth * 3 + 1] ?? 0, all[nth * 3 + 2] ?? 0];
  const faces: Point[] = [];
  const places = new Map<string, number[]>();
  const keys: string[] = [];
  for (let nth = 0; nth < all.length / 3; nth++) {
    const key = at(nth)
      .map((value) => Math.round(value * 200))
      .join();
    keys.push(key);
    const face = Math.floor(nth / 3);
    if (nth % 3 === 0) faces.push(cross(minus(at(nth + 1), at(nth)), minus(at(nth + 2), at(nth))));
    const there = places.get(key);
    if (there === undefined) places.set(key, [face]);
    else there.push(face);
  }
  const least = Math.cos((CREASE * Math.PI) / 180);
  const units = faces.map(unit);
  const normals = new Float32Array(all.length);
  keys.forEach((key, nth) => {
    const own = units[Math.floor(nth / 3)] ?? [0, 0, 1];
    let sum: Point = [0, 0, 0];
    for (const face of places.get(key) ?? []) {
      const [area, other] = [faces[face] ?? own, units[face] ?? own];
      if (dot(own, other) >= least) sum = [sum[0] + area[0], sum[1] + area[1], sum[2] + area[2]];
    }
    normals.set(dot(sum, sum) < 1e-12 ? own : unit(sum), nth * 3);
  });
  return normals;
}
