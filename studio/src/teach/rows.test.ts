import { beforeEach, expect, test, vi } from "vitest";

/** Ends the pages of earlier tests. */
let leaving: Array<() => void> = [];
const listens = globalThis.addEventListener;
globalThis.addEventListener = ((kind: string, listener: () => void) =>
  kind === "pagehide" ? void leaving.push(listener) : listens(kind, listener)) as typeof addEventListener;

/** Leaves the page that was opened last. */
function left() {
  for (const leave of leaving) leave();
  leaving = [];
}
/** The rows of a page that has just been opened, or loaded again. */
async function opened() {
  left();
  vi.resetModules();
  return import("./rows");
}
/** Opens another tab. */
async function beside() {
  vi.resetModules();
  const [ours, theirs] = [leaving, { ...sessionStorage }];
  leaving = [];
  sessionStorage.clear();
  const rows = await import("./rows");
  const leave = leaving;
  leaving = ours;
  for (const [name, value] of Object.entries(theirs)) sessionStorage.setItem(name, value as string);
  return {
    rows,
    closed: () => {
      const mine = { ...sessionStorage };
      sessionStorage.clear();
      for (const one of leave) one();
      sessionStorage.clear();
      for (const [name, value] of Object.entries(mine)) sessionStorage.setItem(name, value as string);
    },
  };
}
beforeEach(() => {
  // Later writes belong to this test.
  vi.useFakeTimers();
  vi.clearAllTimers();
  leaving = [];
  localStorage.clear();
  sessionStorage.clear();
});

test("a new row is inserted after the selected one and selected", async () => {
  const rows = await opened();
  for (let at = 0; at < 3; at++) rows.add({ move: [at, 0, 0, 0] });
  rows.selected.value = 0;
  rows.add({ move: [9, 0, 0, 0] });
  expect(rows.rows.value.map(({ motion }) => motion?.move?.[0])).toEqual([0, 9, 1, 2]);
  expect(rows.selected.value).toBe(1);
});

test("row names are unique", async () => {
  const rows = await opened();
  for (let at = 0; at < 3; at++) rows.add(null);
  rows.selected.value = 0;
  rows.remove();
  rows.add(null);
  const names = rows.rows.value.map(({ name }) => name);
  expect(new Set(names).size).toBe(names.length);
});

test("every change can be undone and redone", async () => {
  const rows = await opened();
  const changes = [
    () => rows.add({ move: [1, 0, 0, 0] }),
    () => rows.add({ move: [2, 0, 0, 0] }),
    () => rows.edit(0, { wait: 500 }),
    () => rows.move(0, 1),
    () => rows.remove(),
  ];
  const states = [JSON.stringify(rows.rows.value)];
  for (const change of changes) {
    change();
    states.push(JSON.stringify(rows.rows.value));
  }
  for (const state of states.toReversed().slice(1)) {
    rows.undo();
    expect(JSON.stringify(rows.rows.value)).toBe(state);
  }
  expect(rows.canUndo.value).toBe(false);
  for (const state of states.slice(1)) {
    rows.redo();
    expect(JSON.stringify(rows.rows.value)).toBe(state);
  }
});

test("an edit without a change adds no undo step", async () => {
  const rows = await opened();
  rows.add(null);
  rows.undo();
  rows.redo();
  rows.edit(0, { wait: null });
  rows.undo();
  expect(rows.rows.value).toEqual([]);
});

test("unsaved rows survive a reload and stay unsaved", async () => {
  const before = await opened();
  before.add({ move: [1, 2, 3, 4] });
  const after = await opened();
  expect(after.rows.value.map(({ motion }) => motion?.move)).toEqual([[1, 2, 3, 4]]);
  expect(after.isSaved.value).toBe(false);
  after.markSaved();
  expect(after.isSaved.value).toBe(true);
});

test("each tab has its own rows, and a new tab starts with the last closed ones", async () => {
  const first = await opened();
  first.add({ move: [1, 0, 0, 0] });
  first.add({ move: [2, 0, 0, 0] });
  const second = await beside();
  while (second.rows.rows.value.length > 0) second.rows.remove();
  second.rows.add({ move: [9, 0, 0, 0] });
  second.rows.remove();
  second.closed();
  const again = await opened();
  expect(again.rows.value).toHaveLength(2);
  again.edit(0, { wait: 1 });
  left();
  sessionStorage.clear();
  expect((await opened()).rows.value).toHaveLength(2);
});

test.each([
  ['{"taught":{"title":"a","rows":[{"na', "cut off"],
  ['{"taught":7,"isSaved":true}', "no program"],
  ['{"taught":{"title":"a","tool":null,"surface":null,"rows":[{"name":5}]},"isSaved":true}', "another row"],
  ['{"rows":[]}', "of another version"],
  ["[]", "a list"],
  ["null", "nothing"],
])("what is kept and cannot be read is set aside: %s", async (text) => {
  localStorage.setItem("magician.teach", text);
  const rows = await opened();
  expect(rows.rows.value).toEqual([]);
  expect(localStorage.getItem("magician.teach.damaged")).toBe(text);
  const { notice } = await import("../store");
  expect(notice.value).toMatchObject({ bad: true });
  rows.add(null);
  expect((await opened()).rows.value).toHaveLength(1);
});
