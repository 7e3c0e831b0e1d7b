// Help beside the page: the book's text for the current route. Works offline, and the page stays
// usable.
import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import * as store from "../store";
import { Button } from "../ui/parts";
import { sentencesOf } from "../words";
import "./help.css";
import texts from "./words.json";

const w = sentencesOf(texts);

/** Help pages, HTML by route; loaded once. */
let pages: Promise<Record<string, string>> | null = null;
async function fetchPages(): Promise<Record<string, string>> {
  const answer = await fetch(new URL("assets/help.json", document.baseURI));
  if (!answer.ok) throw new Error(answer.statusText);
  return answer.json();
}

export function Help() {
  const page = useSignal<string | null>("");
  const box = useRef<HTMLElement>(null);
  const route = store.route.value;
  useEffect(() => {
    let isOver = false;
    pages ??= fetchPages();
    pages.then(
      (all) => {
        if (!isOver) page.value = all[route] ?? null;
        box.current?.scrollTo(0, 0);
      },
      () => {
        pages = null;
        if (!isOver) page.value = null;
      },
    );
    return () => {
      isOver = true;
    };
  }, [route]);
  useEffect(() => {
    const before = document.activeElement;
    box.current?.focus();
    return () => {
      if (before instanceof HTMLElement && before.isConnected) before.focus();
    };
  }, []);
  return (
    <aside class="help" ref={box} tabIndex={-1} aria-label={w("help.title")} data-testid="help-page">
      <div class="help-head">
        <Button
          id="tour"
          class="small"
          text={w("help.tour")}
          press={() => {
            store.sidePanel.value = "tour";
          }}
        />
        <Button
          id="help-close"
          class="quiet small"
          label={w("help.close")}
          text="✕"
          press={() => {
            store.sidePanel.value = null;
          }}
        />
      </div>
      {page.value === null ? (
        <p class="hint" role="alert">
          {w("help.none")}
        </p>
      ) : (
        <article lang="en" dangerouslySetInnerHTML={{ __html: page.value }} />
      )}
    </aside>
  );
}
