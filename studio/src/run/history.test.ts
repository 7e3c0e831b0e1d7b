import { expect, test } from "vitest";
import { History } from "./history";

test("what is undone can be redone, until something else is done", () => {
  const history = new History(0);
  history.commit(1);
  history.commit(2);
  history.undo();
  expect(history.now.value).toBe(1);
  history.redo();
  expect(history.now.value).toBe(2);
  history.undo();
  history.commit(3);
  expect(history.canRedo.value).toBe(false);
  history.undo();
  history.undo();
  expect(history.now.value).toBe(0);
  expect(history.canUndo.value).toBe(false);
  history.undo();
  expect(history.now.value).toBe(0);
});

test("the letters of a text are undone together, those after a pause by themselves", () => {
  const history = new History("");
  history.commit("a", "text");
  history.commit("ab", "text");
  history.seal();
  history.commit("abc", "text");
  history.undo();
  expect(history.now.value).toBe("ab");
  history.undo();
  expect(history.now.value).toBe("");
});

test("what no person has done is no step", () => {
  const history = new History(0);
  history.amend(5);
  expect(history.canUndo.value).toBe(false);
});
