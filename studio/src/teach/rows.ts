// Taught program: the rows of the station's model (`teach.rows`) as a list with undo and redo. The
// station defines what a row means and which plan it becomes. This module keeps the list, and
// restores unsaved rows when the page is opened again.
import { batch, computed, effect, signal } from "@preact/signals";
import type { Methods, Row as PlanRow } from "../api";
import { withMember } from "../settings";
import { Document, isEither, isFlag, isListOf, isMap, isNull, isNumber, isObjectOf, isText, isUnset } from "../storage";

export type Row = Omit<PlanRow, "motion"> & { motion: Motion | null };
export type Taught = Omit<Methods["teach.rows"]["result"], "rows"> & { rows: Row[] };
/** Step of a plan with a target, as far as the table shows it. */
export interface Motion {
  move?: number[];
  joints?: number[];
  by?: string;
  [member: string]: unknown;
}

const STORAGE_KEY = "teach";
const MAX_UNDO_STEPS = 200;

interface State {
  taught: Taught;
  selected: number;
}

const EMPTY_PROGRAM: Taught = { title: "", tool: null, surface: null, rows: [] };

interface StoredProgram {
  taught: Taught;
  isSaved: boolean;
}

const isMove = isEither(isUnset, isListOf(isNumber));
const isRow = isObjectOf({
  name: isText,
  motion: isEither(isNull, (value) => isMap(value) && isObjectOf({ move: isMove, joints: isMove })(value)),
  gripper: isEither(isNull, isText),
  suction: isEither(isNull, isFlag),
  wait: isEither(isNull, isNumber),
});
const isTaught = isObjectOf({
  title: isText,
  tool: isEither(isNull, isText, isListOf(isNumber)),
  surface: isEither(isNull, isMap),
  rows: isListOf(isRow),
});
const document = new Document<StoredProgram>(
  STORAGE_KEY,
  isObjectOf({ taught: isTaught, isSaved: isFlag }),
  ({ taught }) => taught.rows.length === 0,
);

/** Program at the time the page was closed, saved or not. */
const restored = document.read() ?? { taught: EMPTY_PROGRAM, isSaved: true };
export const taught = signal<Taught>(restored.taught);
export const rows = computed(() => taught.value.rows);
/** Index of the row after which new points are inserted. */
export const selected = signal(Math.max(0, taught.value.rows.length - 1));
/** Rows with a tick. */
export const tickedRows = signal<ReadonlySet<Row>>(new Set());
/** Rows as last saved. */
const savedRows = signal<Row[]>(restored.isSaved ? restored.taught.rows : []);
export const isSaved = computed(() => rows.value.length === 0 || rows.value === savedRows.value);

const undoStack = signal<State[]>([]);
const redoStack = signal<State[]>([]);
export const canUndo = computed(() => undoStack.value.length > 0);
export const canRedo = computed(() => redoStack.value.length > 0);

effect(() => document.write({ taught: taught.value, isSaved: isSaved.value }));
addEventListener("beforeunload", (event) => {
  if (!isSaved.value) event.preventDefault();
});

const currentState = (): State => ({ taught: taught.value, selected: selected.value });

/** Replaces the rows. Can be undone. */
export function change(next: Partial<Taught>, select = selected.value): void {
  batch(() => {
    undoStack.value = [...undoStack.value.slice(1 - MAX_UNDO_STEPS), currentState()];
    redoStack.value = [];
    taught.value = { ...taught.value, ...next };
    selected.value = Math.max(0, Math.min(select, rows.value.length - 1));
    const left = new Set(rows.value);
    tickedRows.value = new Set([...tickedRows.value].filter((row) => left.has(row)));
  });
}

function restoreFrom(from: typeof undoStack, to: typeof undoStack): void {
  const state = from.value.at(-1);
  if (state === undefined) return;
  batch(() => {
    from.value = from.value.slice(0, -1);
    to.value = [...to.value, currentState()];
    taught.value = state.taught;
    selected.value = state.selected;
    tickedRows.value = new Set();
  });
}
export const undo = () => restoreFrom(undoStack, redoStack);
export const redo = () => restoreFrom(redoStack, undoStack);

export function markSaved(): void {
  savedRows.value = rows.value;
}

const unusedName = (): string => {
  const names = new Set(rows.value.map((row) => row.name));
  let number = rows.value.length + 1;
  while (names.has(`P${number}`)) number++;
  return `P${number}`;
};

/** Inserts a row after the selected one, and selects it. */
export function add(motion: Motion | null, more: Partial<Taught> = {}): void {
  const row: Row = { name: unusedName(), motion, gripper: null, suction: null, wait: null };
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
  const gone =
    tickedRows.value.size > 0 ? tickedRows.value : new Set(rows.value.slice(selected.value, selected.value + 1));
  change({ rows: rows.value.filter((row) => !gone.has(row)) });
}

export const tickRow = (row: Row, on: boolean): void => void (tickedRows.value = withMember(tickedRows.value, row, on));
