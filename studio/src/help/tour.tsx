// Tour of one minute that points at the parts of the page. It moves nothing.
import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import * as store from "../store";
import { Button } from "../ui/parts";
import { sentencesOf } from "../words";
import "./help.css";
import texts from "./words.json";

const w = sentencesOf(texts);

/** Steps with the elements they point at. A step is skipped if its element is not on the page. */
const STEPS = [
  ["tour.stop", '[data-testid="stop"]'],
  ["tour.control", ".lease"],
  ["tour.look", ".view-card, .view"],
  ["tour.jog", ".jog-card"],
  ["tour.draw", 'nav a[href="#/draw"]'],
  ["tour.teach", 'nav a[href="#/teach"]'],
  ["tour.gallery", 'nav a[href="#/gallery"]'],
  ["tour.help", '[data-testid="help"]'],
] as const;
/** Margin around the element, and its distance from the card, px. */
const [HOLE_MARGIN, CARD_DISTANCE] = [6, 12];

const visibleElement = (selector: string) => {
  const all = [...document.querySelectorAll<HTMLElement>(selector)];
  return all.find((element) => element.getClientRects().length > 0);
};

export function Tour() {
  const at = useSignal(0);
  const hole = useSignal<DOMRect | null>(null);
  const card = useRef<HTMLDialogElement>(null);
  const steps = STEPS.filter(([, selector]) => visibleElement(selector) !== undefined);
  const step = steps[Math.min(at.value, steps.length - 1)];
  const end = () => {
    store.sidePanel.value = null;
  };
  useEffect(() => {
    // The tour is about Move, which shows the most.
    if (store.route.peek() !== "move") location.hash = "#/move";
    const element = card.current;
    element?.show();
    element?.querySelector<HTMLElement>("[data-first]")?.focus();
  }, []);
  useEffect(() => {
    const element = step === undefined ? undefined : visibleElement(step[1]);
    element?.scrollIntoView({ block: "center", inline: "center" });
    const look = () => {
      hole.value = element?.getBoundingClientRect() ?? null;
    };
    look();
    const over = new AbortController();
    addEventListener("scroll", look, { capture: true, passive: true, signal: over.signal });
    addEventListener("resize", look, over);
    return () => over.abort();
  }, [step?.[0]]);
  if (step === undefined) return null;
  const is = hole.value;
  const isLow = is !== null && is.top + is.height / 2 > innerHeight / 2;
  const place =
    is === null
      ? {}
      : {
          left: `clamp(12px, ${is.left + is.width / 2 - 170}px, calc(100vw - min(340px, 100vw - 24px) - 12px))`,
          ...(isLow
            ? { bottom: `${Math.min(innerHeight - is.top + CARD_DISTANCE + HOLE_MARGIN, innerHeight - 240)}px` }
            : { top: `${Math.min(is.bottom + CARD_DISTANCE + HOLE_MARGIN, innerHeight - 240)}px` }),
        };
  const last = at.value >= steps.length - 1;
  return (
    <div
      class="tour"
      onKeyDown={(event) => {
        if (event.key === "Escape") end();
      }}
    >
      {is === null ? null : (
        <div
          class="tour-hole"
          style={{
            left: `${is.left - HOLE_MARGIN}px`,
            top: `${is.top - HOLE_MARGIN}px`,
            width: `${is.width + 2 * HOLE_MARGIN}px`,
            height: `${is.height + 2 * HOLE_MARGIN}px`,
          }}
        />
      )}
      <dialog ref={card} class="tour-card" style={place} aria-labelledby="tour-title" data-testid="tour-card">
        <h2 id="tour-title">{w("tour.title", { step: at.value + 1, steps: steps.length })}</h2>
        <p aria-live="polite">{w(step[0])}</p>
        <div class="buttons-row">
          <Button id="tour-end" class="quiet" text={w("tour.end")} press={end} />
          {at.value > 0 ? <Button id="tour-back" text={w("tour.back")} press={() => at.value--} /> : null}
          <Button
            id="tour-next"
            class="primary"
            data-first
            text={last ? w("tour.end") : w("tour.next")}
            press={() => (last ? end() : at.value++)}
          />
        </div>
      </dialog>
    </div>
  );
}
