// Taught program: the rows of the station's model (`teach.rows`) as a list with undo and redo. The
// station defines what a row means and which plan it becomes. This module keeps the list, and
// restores unsaved rows when the page is opened again.
import { batch, computed, effect, signal } from "@preact/signals";
import type { Methods, Row as PlanRow } from "../api";
import { toggled } from "../settings";
import { Document, has, isFlag, isListOf, isMap, isNull, isNumber, isOr, isText, isUnset } from "../shelf";

export type Row = Omit<PlanRow, "motion"> & { motion: Motion | null };
export type Taught = Omit<Methods["teach.rows"]["result"], "rows"> & { rows: Row[] };
/** Step of a plan with a target, as far as the table shows it. */
export interface Motion {
  move?: number[];
  joints?: number[];
  by?: string;
  [member: string]: unknown;
}

const KEY = "teach";
const MOST = 200;

interface State {
  taught: Taught;
  selected: number;
}

const nothing: Taught = { title: "", tool: null, surface: null, rows: [] };

interface Kept {
  taught: Taught;
  isSaved: boolean;
}

const isMove = isOr(isUnset, isListOf(isNumber));
const isRow = has({
  name: isText,
  motion: isOr(isNull, (value) => isMap(value) && has({ move: isMove, joints: isMove })(value)),
  gripper: isOr(isNull, isText),
  suction: isOr(isNull, isFlag),
  wait: isOr(isNull, isNumber),
});
const isTaught = has({
  title: isText,
  tool: isOr(isNull, isText, isListOf(isNumber)),
  surface: isOr(isNull, isMap),
  rows: isListOf(isRow),
});
const document = new Document<Kept>(
  KEY,
  has({ taught: isTaught, isSaved: isFlag }),
  ({ taught }) => taught.rows.length === 0,
);

/** Program at the time the page was closed, saved or not. */
const left = document.read() ?? { taught: nothing, isSaved: true };
export const taught = signal<Taught>(left.taught);
export const rows = computed(() => taught.value.rows);
/** Index of the row after which new points are inserted. */
export const selected = signal(Math.max(0, taught.value.rows.length - 1));
/** Rows with a tick. */
export const picked = signal<ReadonlySet<Row>>(new Set());
/** Rows as last saved. */
const saved = signal<Row[]>(left.isSaved ? left.taught.rows : []);
export const isSaved = computed(() => rows.value.length === 0 || rows.value === saved.value);

const before = signal<State[]>([]);
const after = signal<State[]>([]);
export const canUndo = computed(() => before.value.length > 0);
export const canRedo = computed(() => after.value.length > 0);

effect(() => document.write({ taught: taught.value, isSaved: isSaved.value }));
addEventListener("beforeunload", (event) => {
  if (!isSaved.value) event.preventDefault();
});

const now = (): State => ({ taught: taught.value, selected: selected.value });

/** Replaces the rows. Can be undone. */
export function change(next: Partial<Taught>, select = selected.value): void {
  batch(() => {
    before.value = [...before.value.slice(1 - MOST), now()];
    after.value = [];
    taught.value = { ...taught.value, ...next };
    selected.value = Math.max(0, Math.min(select, rows.value.length - 1));
    const left = new Set(rows.value);
    picked.value = new Set([...picked.value].filter((row) => left.has(row)));
  });
}

function back(from: typeof before, to: typeof before): void {
  const state = from.value.at(-1);
  if (state === undefined) return;
  batch(() => {
    from.value = from.value.slice(0, -1);
    to.value = [...to.value, now()];
    taught.value = state.taught;
    selected.value = state.selected;
    picked.value = new Set();
  });
}
export const undo = () => back(before, after);
export const redo = () => back(after, before);

export function markSaved(): void {
  saved.value = rows.value;
}

const freshName = (): string => {
  const names = new Set(rows.value.map((row) => row.name));
  let number = rows.value.length + 1;
  while (names.has(`P${number}`)) number++;
  return `P${number}`;
};

/** Inserts a row after the selected one, and selects it. */
export function add(motion: Motion | null, more: Partial<Taught> = {}): void {
  const row: Row = { name: freshName(), motion, gripper: null, suction: null, wait: null };
  const at = Math.min(selected.value + 1, rows.value.length);
  change({ ...more, rows: rows.value.toSpliced(at, 0, row) }, at);
}

/** Inserts rows after the selected one as one undo step, and selects the last. */
export function insert(made: readonly Row[], more: Partial<Taught> = {}): void {
  const at = Math.min(selected.value + 1, rows.value.length);
  change({ ...more, rows: rows.value.toSpliced(at, 0, ...made) }, at + made.length - 1);
}

export function edit(nth: number, next: Partial<Row>): void {
  const row = rows.value[nth];
  if (row === undefined) return;
  const made = { ...row, ...next };
  if (JSON.stringify(made) === JSON.stringify(row)) return;
  change({ rows: rows.value.with(nth, made) });
}

/** Moves a row to another index. */
export function move(from: number, to: number): void {
  const row = rows.value[from];
  if (row === undefined || to < 0 || to >= rows.value.length || from === to) return;
  change({ rows: rows.value.toSpliced(from, 1).toSpliced(to, 0, row) }, to);
}

/** Deletes the ticked rows, or the selected one if no row is ticked. */
export function remove(): void {
  const gone = picked.value.size > 0 ? picked.value : new Set(rows.value.slice(selected.value, selected.value + 1));
  change({ rows: rows.value.filter((row) => !gone.has(row)) });
}

export const pick = (row: Row, on: boolean): void => void (picked.value = toggled(picked.value, row, on));
