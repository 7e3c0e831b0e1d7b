// Files dropped anywhere on the page go to the open route, so that the browser never opens one in
// place of the page.
import { useEffect, useRef } from "preact/hooks";
import { t } from "../i18n";
import * as store from "../store";

type Opens = (files: File[]) => unknown;

/** Handlers of the open route; the last one counts. */
const takers: Array<{ opens: () => Opens | null }> = [];

/** Handles files dropped anywhere on the page while the component is mounted; null while it cannot. */
export function useDropped(open: Opens | null): void {
  const now = useRef(open);
  now.current = open;
  useEffect(() => {
    const taker = { opens: () => now.current };
    takers.push(taker);
    return () => void takers.splice(takers.indexOf(taker), 1);
  }, []);
}

const hasFiles = ({ dataTransfer }: DragEvent): boolean => dataTransfer?.types.includes("Files") === true;

export function dropped(event: DragEvent): void {
  if (!hasFiles(event)) return;
  // A card that takes them has said so.
  if (event.defaultPrevented) return;
  event.preventDefault();
  const taker = takers.at(-1);
  const open = taker?.opens();
  if (open) void open([...(event.dataTransfer?.files ?? [])]);
  else store.say(t(taker === undefined ? "drop.elsewhere" : (store.why.value ?? "drop.elsewhere")), true);
}

window.addEventListener("dragover", (event) => hasFiles(event) && event.preventDefault());
window.addEventListener("drop", dropped);
