// Where a drawing lies on the sheet: as its last check has it, and as a hand or a typed number wants it until the next one.
import { computed, effect, signal } from "@preact/signals";
import { boundsOf } from "../view/flat";
import * as check from "./check";

export interface Place {
  at: [x: number, y: number];
  /** Its size, 1 being the true one. */
  scale: number;
  /** Counter-clockwise, degrees. */
  turn: number;
}
export type Point = readonly [x: number, y: number];

/** Nothing is wanted of a drawing that lies where the station puts it, no larger than it fits. */
export const wanted = signal<Place | null>(null);
/** How the picture lies that the last check made. */
export const found = computed(() => check.report.value?.placed ?? null);
export const place = computed(() => wanted.value ?? found.value);

/** Another program lies elsewhere. */
const what = computed(() => check.chosen.value?.program ?? check.chosen.value?.format);
effect(() => {
  void what.value;
  wanted.value = null;
});

/** What the station is told of it, in place of what a person is asked elsewhere. */
export const setup = computed(() => {
  const to = wanted.value;
  return {
    at: to?.at,
    scale: to?.scale,
    rotate: to?.turn,
    fit: to === null || undefined,
    width: undefined,
    place: undefined,
  };
});

const rounded = (value: number, digits: number) => Math.round(value * 10 ** digits) / 10 ** digits;
/** The same turn, as near to none as it can be said. */
const unwound = (turn: number) => turn - 360 * Math.round(turn / 360);

/** Whether the picture lies as it is wanted: what the station says of it is rounded. */
export const isFound = computed(() => {
  const [to, is] = [place.value, found.value];
  if (to === null || is === null) return false;
  const apart = Math.hypot(to.at[0] - is.at[0], to.at[1] - is.at[1]);
  return apart < 0.05 && Math.abs(to.scale / is.scale - 1) < 0.005 && Math.abs(unwound(to.turn - is.turn)) < 0.05;
});

export function change(by: Partial<Place>): void {
  const now = place.value;
  if (now === null) return;
  const { at, scale, turn } = { ...now, ...by };
  if (!(scale > 0)) return;
  wanted.value = {
    at: [rounded(at[0], 2), rounded(at[1], 2)],
    scale: Number(scale.toPrecision(6)),
    turn: rounded(unwound(turn), 2),
  };
}

export function turned([x, y]: Point, degrees: number): [number, number] {
  const [cos, sin] = [Math.cos((degrees * Math.PI) / 180), Math.sin((degrees * Math.PI) / 180)];
  return [x * cos - y * sin, x * sin + y * cos];
}

/** The sides of what is drawn as the picture has it, as it lies in its file. */
const sides = computed<Point>(() => {
  const placed = found.value;
  if (placed === null) return [0, 0];
  const points = (check.report.value?.preview?.strokes ?? []).flatMap((stroke) =>
    stroke.points.map(([x = 0, y = 0]) => turned([x, y], -placed.turn)),
  );
  const { width, height } = boundsOf(points);
  return [width, height];
});

/** How wide and high it becomes. */
export const size = computed<Point>(() => {
  const [is, was] = [place.value?.scale ?? 1, found.value?.scale ?? 1];
  return [(sides.value[0] * is) / was, (sides.value[1] * is) / was];
});
export const setWidth = (width: number) =>
  size.value[0] > 0 && change({ scale: ((place.value?.scale ?? 1) * width) / size.value[0] });
