import { beforeEach, expect, test, vi } from "vitest";

let pagehideListeners: Array<() => void> = [];
const addListener = globalThis.addEventListener;
globalThis.addEventListener = ((kind: string, listener: () => void) =>
  kind === "pagehide" ? void pagehideListeners.push(listener) : addListener(kind, listener)) as typeof addEventListener;
/** Opens or reloads the page, and returns its workshops. */
async function reloadPage() {
  for (const listener of pagehideListeners) listener();
  pagehideListeners = [];
  vi.resetModules();
  return (await import("./bench")).benches;
}
beforeEach(() => {
  vi.useFakeTimers();
  vi.clearAllTimers();
  pagehideListeners = [];
  localStorage.clear();
  sessionStorage.clear();
});

test("each workshop restores its objects after a reload", async () => {
  const before = await reloadPage();
  before.pen.addText("Hello");
  before.pen.addShape("star", "Star");
  const after = await reloadPage();
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
  const { pen } = await reloadPage();
  expect(pen.doc.now.value.items).toEqual([]);
  expect(localStorage.getItem("magician.draw.damaged")).toBe(text);
});
