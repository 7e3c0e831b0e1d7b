// Files dropped anywhere on the page go to the open route, so that the browser never opens one in
// place of the page.
import { useEffect, useRef } from "preact/hooks";
import { t } from "../i18n";
import * as store from "../store";

type OpenFiles = (files: File[]) => unknown;

/** Handlers of the open route; the last one counts. */
const handlers: Array<{ opens: () => OpenFiles | null }> = [];

/** Handles files dropped anywhere on the page while the component is mounted; null while it cannot. */
export function useFileDrop(open: OpenFiles | null): void {
  const now = useRef(open);
  now.current = open;
  useEffect(() => {
    const taker = { opens: () => now.current };
    handlers.push(taker);
    return () => void handlers.splice(handlers.indexOf(taker), 1);
  }, []);
}

const hasFiles = ({ dataTransfer }: DragEvent): boolean => dataTransfer?.types.includes("Files") === true;

export function handleDrop(event: DragEvent): void {
  if (!hasFiles(event)) return;
  // A card that takes them has said so.
  if (event.defaultPrevented) return;
  event.preventDefault();
  const taker = handlers.at(-1);
  const open = taker?.opens();
  if (open) void open([...(event.dataTransfer?.files ?? [])]);
  else store.notify(t(taker === undefined ? "drop.elsewhere" : (store.why.value ?? "drop.elsewhere")), true);
}

window.addEventListener("dragover", (event) => hasFiles(event) && event.preventDefault());
window.addEventListener("drop", handleDrop);
