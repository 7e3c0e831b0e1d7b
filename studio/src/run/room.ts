// Free room on the sheet: the largest free place for a drawing of a given shape.
import { boundsOf, type Frame, type Points } from "../view/flat";

/** Limits of a drawing in the arm's x and y, mm. */
export interface Room {
  /** Reach of the tip. Areas inside an even number of these lines are out of reach. */
  outlines: readonly Points[];
  /** Corners of the sheet of paper; null without one. */
  paper: Points | null;
  /** Areas that are drawn on or reserved. */
  taken: readonly Frame[];
}
export interface Spot {
  at: [x: number, y: number];
  scale: number;
}

/** Cell size of the search grid, mm. */
const CELL_SIZE = 3;
/** Margins at the edges of paper and reach, and between drawings, mm. */
const [MARGIN, DRAWING_GAP] = [10, 6];
/**
 * Smallest x of automatic places, mm: beside or behind the base the arm would stand over the
 * drawing.
 */
const LEAST_X = 110;
const BISECTION_STEPS = 14;

export function isInside(points: Points, x: number, y: number): boolean {
  let inside = false;
  for (let at = 0, before = points.length - 1; at < points.length; before = at++) {
    const [[ax = 0, ay = 0] = [], [bx = 0, by = 0] = []] = [points[at], points[before]];
    if (ay > y !== by > y && x < ((bx - ax) * (y - ay)) / (by - ay) + ax) inside = !inside;
  }
  return inside;
}

/**
 * Distance up to which lines belong to one drawing, as a share of their size, and its upper limit,
 * mm.
 */
const [CLUSTER_SHARE, MAX_CLUSTER_GAP] = [0.25, 35];

/**
 * Boxes of lines that lie together: nearby lines are one drawing, and the room between them does
 * not count as free.
 */
export function clusters(strokes: readonly Points[]): Frame[] {
  let boxes = strokes.filter((points) => points.length > 0).map((points) => boundsOf(points));
  for (let before = Infinity; boxes.length < before; ) {
    before = boxes.length;
    const merged: Frame[] = [];
    for (const box of boxes) {
      const near = merged.findIndex((one) => overlaps(withMargin(one), withMargin(box)));
      const other = merged[near];
      if (other === undefined) merged.push(box);
      else merged[near] = unionOf(other, box);
    }
    boxes = merged;
  }
  return boxes;
}
function withMargin({ x, y, width, height }: Frame): Frame {
  const by = Math.min(MAX_CLUSTER_GAP, Math.max(DRAWING_GAP / 2, CLUSTER_SHARE * Math.max(width, height)));
  return { x: x - by, y: y - by, width: width + 2 * by, height: height + 2 * by };
}
/** True if two boxes overlap. */
export const overlaps = (one: Frame, other: Frame): boolean =>
  one.x < other.x + other.width &&
  other.x < one.x + one.width &&
  one.y < other.y + other.height &&
  other.y < one.y + one.height;
const unionOf = (one: Frame, other: Frame): Frame =>
  boundsOf(
    [one, other].flatMap(({ x, y, width, height }) => [
      [x, y],
      [x + width, y + height],
    ]),
  );

/** Grid of free cells, with prefix sums of the occupied ones in both directions. */
class Grid {
  readonly box: Frame;
  readonly rows: number;
  readonly columns: number;
  private readonly sums: Int32Array;

  constructor({ outlines, paper, taken }: Room) {
    const reach = boundsOf(outlines.flat());
    const box = paper === null ? reach : overlapOf(reach, boundsOf(paper));
    const x = Math.max(box.x, LEAST_X);
    this.box = { ...box, x, width: Math.max(0, box.x + box.width - x) };
    this.columns = Math.floor(this.box.width / CELL_SIZE);
    this.rows = Math.floor(this.box.height / CELL_SIZE);
    const inside = new Uint8Array(this.columns * this.rows);
    for (let column = 0; column < this.columns; column++) {
      for (let row = 0; row < this.rows; row++) {
        const [px, py] = [this.box.x + (column + 0.5) * CELL_SIZE, this.box.y + (row + 0.5) * CELL_SIZE];
        const crossed = outlines.reduce((count, outline) => count + Number(isInside(outline, px, py)), 0);
        if (crossed % 2 === 1 && (paper === null || isInside(paper, px, py))) inside[column * this.rows + row] = 1;
      }
    }
    const isIn = (column: number, row: number) =>
      column >= 0 && column < this.columns && row >= 0 && row < this.rows && inside[column * this.rows + row] === 1;
    const margin = Math.ceil(MARGIN / CELL_SIZE);
    const edges = [
      [margin, 0],
      [-margin, 0],
      [0, margin],
      [0, -margin],
    ] as const;
    const isTaken = (px: number, py: number) =>
      taken.some(
        (one) =>
          px > one.x - DRAWING_GAP &&
          px < one.x + one.width + DRAWING_GAP &&
          py > one.y - DRAWING_GAP &&
          py < one.y + one.height + DRAWING_GAP,
      );
    this.sums = new Int32Array((this.columns + 1) * (this.rows + 1));
    const wide = this.rows + 1;
    for (let column = 0; column < this.columns; column++) {
      for (let row = 0; row < this.rows; row++) {
        const [px, py] = [this.box.x + (column + 0.5) * CELL_SIZE, this.box.y + (row + 0.5) * CELL_SIZE];
        const isFree = isIn(column, row) && edges.every(([dx, dy]) => isIn(column + dx, row + dy)) && !isTaken(px, py);
        const [left, below, both] = [column * wide + row + 1, (column + 1) * wide + row, column * wide + row].map(
          (at) => this.sums[at] ?? 0,
        ) as [number, number, number];
        this.sums[(column + 1) * wide + row + 1] = left + below - both + Number(!isFree);
      }
    }
  }

  /** Free place for a box of cells, closest to a point; null without one. */
  place(columns: number, rows: number, [nearX, nearY]: readonly number[]): [number, number] | null {
    const wide = this.rows + 1;
    let [found, least]: [[number, number] | null, number] = [null, Infinity];
    for (let column = 0; column + columns <= this.columns; column++) {
      for (let row = 0; row + rows <= this.rows; row++) {
        const blocked =
          (this.sums[(column + columns) * wide + row + rows] ?? 0) -
          (this.sums[column * wide + row + rows] ?? 0) -
          (this.sums[(column + columns) * wide + row] ?? 0) +
          (this.sums[column * wide + row] ?? 0);
        if (blocked > 0) continue;
        const at: [number, number] = [
          this.box.x + (column + columns / 2) * CELL_SIZE,
          this.box.y + (row + rows / 2) * CELL_SIZE,
        ];
        const far = Math.hypot(at[0] - (nearX ?? 0), at[1] - (nearY ?? 0));
        if (far < least) [found, least] = [at, far];
      }
    }
    return found;
  }
}

function overlapOf(one: Frame, other: Frame): Frame {
  const [x, y] = [Math.max(one.x, other.x), Math.max(one.y, other.y)];
  const width = Math.max(0, Math.min(one.x + one.width, other.x + other.width) - x);
  return { x, y, width, height: Math.max(0, Math.min(one.y + one.height, other.y + other.height) - y) };
}

/**
 * Finds the place for a drawing of this size along the arm's x and y, mm, at the largest scale that
 * fits, up to `most`. Null if it does not fit at `least`.
 */
export function freeSpot(
  room: Room,
  [alongX, alongY]: readonly [number, number],
  least: number,
  most: number,
): Spot | null {
  if (room.outlines.length === 0 || !(alongX + alongY > 0)) return null;
  const grid = new Grid(room);
  const middle = [grid.box.x + grid.box.width / 2, grid.box.y + grid.box.height / 2];
  const cells = (side: number) => Math.max(1, Math.ceil(side / CELL_SIZE));
  const place = (scale: number) => grid.place(cells(alongX * scale), cells(alongY * scale), middle);
  let [fits, over] = [
    least,
    Math.min(most, (2 * Math.max(grid.box.width, grid.box.height)) / Math.max(alongX, alongY)),
  ];
  let at = place(fits);
  if (at === null) return null;
  const whole = place(over);
  if (whole !== null) return { at: whole, scale: over };
  for (let halving = 0; halving < BISECTION_STEPS; halving++) {
    const middle = (fits + over) / 2;
    const there = place(middle);
    if (there === null) over = middle;
    else [fits, at] = [middle, there];
  }
  return { at, scale: fits };
}
