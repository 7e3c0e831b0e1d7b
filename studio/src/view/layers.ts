// Lines and boxes shown with the arm, in layers, in 3D or from above. A panel may set its layer
// before the picture is loaded, and removes it with an empty list. Coordinates are those of poses,
// mm.
import { signal } from "@preact/signals";

/**
 * Default height of the table, mm, at which the cup of an arm touches the surface its base stands
 * on.
 */
export const USUAL_TABLE = -60;

export type Layer = "planned" | "points" | "fence" | "paper" | "sheet" | "belt" | "objects";

export interface Lines {
  /** Points [x, y, z], connected in this order. */
  points: ReadonlyArray<readonly number[]>;
  /** CSS colour, or the name of a custom property such as `--accent`. */
  color: string;
  closed?: boolean;
  /** Draws the points themselves instead of the line. */
  dots?: boolean;
  opacity?: number;
}

export interface Box {
  /** Centre of the box's bottom face, and its rotation about z, degrees. */
  at: readonly number[];
  size: readonly number[];
  turn?: number;
  color: string;
  opacity?: number;
  /** Name of the object, if the user can drag it. */
  name?: string;
  /** True if the tool carries it. */
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

/** Called with the position to which the user drags a named box; null disables dragging. */
export const onObjectDragged = signal<((name: string, at: [number, number, number]) => void) | null>(null);

export interface Target {
  x: number;
  y: number;
  z: number;
  r: number;
}
/** Target pose that the user is about to choose, shown as a translucent tool. */
export const target = signal<Target | null>(null);
/** Called with a position pressed on the table in the view from above. */
export const onTablePressed = signal<((x: number, y: number) => void) | null>(null);
