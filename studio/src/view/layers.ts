// What is shown beside the arm: lines and boxes in layers, in 3D or from above. Any panel says what its layer shows, before the
// picture is there or after; it takes it away with an empty list. Coordinates are those of poses, mm.
import { signal } from "@preact/signals";

/** Height of the table where nothing says another, mm: there the cup of an arm touches what its base stands on. */
export const USUAL_TABLE = -60;

export type Layer = "planned" | "points" | "fence" | "paper" | "sheet" | "belt" | "objects";

export interface Lines {
  /** Points [x, y, z], joined in their order. */
  points: ReadonlyArray<readonly number[]>;
  /** A colour, or the name of one of the page's: `--accent`. */
  color: string;
  closed?: boolean;
  /** The points themselves, not what joins them. */
  dots?: boolean;
  opacity?: number;
}

export interface Box {
  /** The middle of its underside, and how it is turned about z, degrees. */
  at: readonly number[];
  size: readonly number[];
  turn?: number;
  color: string;
  opacity?: number;
  /** What it is called, where a hand can take it. */
  name?: string;
  /** Whether the tool carries it. */
  held?: boolean;
}

export interface Shapes {
  lines: readonly Lines[];
  boxes: readonly Box[];
}

export const layers = signal<ReadonlyMap<Layer, Shapes>>(new Map());

export function show(layer: Layer, lines: readonly Lines[], boxes: readonly Box[] = []): void {
  const next = new Map(layers.peek());
  if (lines.length + boxes.length > 0) next.set(layer, { lines, boxes });
  else if (!next.delete(layer)) return;
  layers.value = next;
}

/** Who is told where a hand puts a box with a name; without it boxes stay where they are. */
export const hand = signal<((name: string, at: [number, number, number]) => void) | null>(null);

export interface Target {
  x: number;
  y: number;
  z: number;
  r: number;
}
/** Where the arm is to go, as far as somebody is about to say so: a ghost of the tool is shown there. */
export const target = signal<Target | null>(null);
/** Who is told where the table is pressed, seen from above. */
export const pressed = signal<((x: number, y: number) => void) | null>(null);
