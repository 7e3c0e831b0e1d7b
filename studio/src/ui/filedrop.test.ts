import { expect, test } from "vitest";
import * as store from "../store";
import { handleDrop } from "./filedrop";

const drop = (types: string[], isTaken = false) => {
  const event = new Event("drop", { cancelable: true }) as DragEvent;
  Object.defineProperty(event, "dataTransfer", { value: { types, files: [] } });
  if (isTaken) event.preventDefault();
  return event;
};

test("a dropped file without a handler is refused with a notice and does not replace the page", () => {
  const event = drop(["Files"]);
  handleDrop(event);
  expect(event.defaultPrevented).toBe(true);
  expect(store.notice.value?.bad).toBe(true);
});

test("dragged text and files that a card has taken are ignored", () => {
  store.notice.value = null;
  const words = drop(["text/plain"]);
  handleDrop(words);
  expect(words.defaultPrevented).toBe(false);
  handleDrop(drop(["Files"], true));
  expect(store.notice.value).toBeNull();
});
