import { beforeEach, expect, test, vi } from "vitest";

let leaving: Array<() => void> = [];
const listens = globalThis.addEventListener;
globalThis.addEventListener = ((kind: string, listener: () => void) =>
  kind === "pagehide" ? void leaving.push(listener) : listens(kind, listener)) as typeof addEventListener;
/** The workshops of a page that has just been opened, or loaded again. */
async function opened() {
  for (const leave of leaving) leave();
  leaving = [];
  vi.resetModules();
  return (await import("./bench")).benches;
}
beforeEach(() => {
  vi.useFakeTimers();
  vi.clearAllTimers();
  leaving = [];
  localStorage.clear();
  sessionStorage.clear();
});

test("each workshop restores its objects after a reload", async () => {
  const before = await opened();
  before.pen.addText("Hello");
  before.pen.addShape("star", "Star");
  const after = await opened();
  expect(after.pen.doc.now.value.items.map(({ name }) => name)).toEqual(["Hello", "Star"]);
  expect(after.laser.doc.now.value.items).toEqual([]);
  expect(after.pen.doc.canUndo.value).toBe(false);
  after.pen.addText("more");
  const ids = after.pen.doc.now.value.items.map(({ id }) => id);
  expect(new Set(ids).size).toBe(3);
});

test.each([
  '{"doc":{"items":[{"id":1,"source":{"text":"a"},"format":"text","name":"a","color":null,"values":{},"place":{"at":[0,0],"scale":0,"turn":0}}],"chosen":1},"common":{}}',
  '{"doc":{"items":{},"chosen":null},"common":{}}',
  '{"doc":',
])("a damaged sheet is set aside: %s", async (text) => {
  localStorage.setItem("magician.draw", text);
  const { pen } = await opened();
  expect(pen.doc.now.value.items).toEqual([]);
  expect(localStorage.getItem("magician.draw.damaged")).toBe(text);
});
