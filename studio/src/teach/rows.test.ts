import { beforeEach, expect, test, vi } from "vitest";

/** Rows of a page that was just opened. */
async function opened() {
  vi.resetModules();
  return import("./rows");
}
beforeEach(() => localStorage.clear());

test("a new row comes behind the selected one and is selected", async () => {
  const rows = await opened();
  for (let at = 0; at < 3; at++) rows.add({ move: [at, 0, 0, 0] });
  rows.selected.value = 0;
  rows.add({ move: [9, 0, 0, 0] });
  expect(rows.rows.value.map(({ motion }) => motion?.move?.[0])).toEqual([0, 9, 1, 2]);
  expect(rows.selected.value).toBe(1);
});

test("names are not given twice", async () => {
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

test("an edit that changes nothing is no step of undo", async () => {
  const rows = await opened();
  rows.add(null);
  rows.undo();
  rows.redo();
  rows.edit(0, { wait: null });
  rows.undo();
  expect(rows.rows.value).toEqual([]);
});

test("what was not saved is there again, and is not saved", async () => {
  const before = await opened();
  before.add({ move: [1, 2, 3, 4] });
  const after = await opened();
  expect(after.rows.value.map(({ motion }) => motion?.move)).toEqual([[1, 2, 3, 4]]);
  expect(after.isSaved.value).toBe(false);
  after.markSaved();
  expect(after.isSaved.value).toBe(true);
});
