import { expect, test } from "vitest";
import { History } from "./history";

test("an undone step can be redone until the next change", () => {
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

test("the letters of a text are undone together, those after a seal separately", () => {
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

test("changes not made by the user are no undo steps", () => {
  const history = new History(0);
  history.amend(5);
  expect(history.canUndo.value).toBe(false);
});
