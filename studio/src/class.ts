// A class: whose turn it is, and who waits for one.
import { computed, effect, signal } from "@preact/signals";
import type { Result } from "./client";
import { t } from "./i18n";
import { duration } from "./run/jobs";
import { call, notified, show } from "./session";
import * as store from "./store";

type Turns = Result<"turn.list">;
/** Null where there is no class. */
export const turns = signal<Turns | null>(null);
/** When they were told, and how long ago that is, s: what is left of a turn runs from there. */
let toldAt = 0;
const age = signal(0);
setInterval(() => (age.value = turns.value === null ? 0 : Math.floor((performance.now() - toldAt) / 1000)), 1000);

function hear(told: Turns): void {
  toldAt = performance.now();
  age.value = 0;
  turns.value = told.turn_s === null && !told.arms.some(({ frozen }) => frozen) ? null : told;
}

// A station without classes does not know the method.
effect(() => {
  if (store.socket.value === "up") call("turn.list", {}).then(hear, () => (turns.value = null));
  else turns.value = null;
});
notified.add((method, params) => {
  if (method === "turn.changed") hear(params);
  if (method === "turn.ending" && params.person === store.pupil.value) store.say(t("class.ending", { arm: params.arm, left: duration(params.left_s) }));
  if (method !== "turn.granted") return;
  show(params.arm);
  store.say(t("class.granted", { arm: params.arm }));
});

/** A turn in words: whose, and how long it is still. */
export function wordsOf(arm: string): string | null {
  const turn = turns.value?.arms.find((one) => one.arm === arm);
  if (turn?.frozen) return t("class.frozen");
  if (!turn?.person) return null;
  const left = turn.left_s === null ? "" : ` ${duration(turn.left_s - (turn.state === "running" ? age.value : 0))}`;
  return `${t(`class.${turn.state as "running"}`, { name: turn.person })}${left}`;
}

/** The turn or the place of the pupil who is signed in. */
export const mine = computed(() => {
  const is = ({ person }: { person: string | null }) => person !== null && person === store.pupil.value;
  const turn = turns.value?.arms.find(is);
  const place = turns.value?.queue.find(is)?.place;
  return turn ? `${turn.arm}: ${wordsOf(turn.arm)}` : place === undefined ? null : t("class.place", { n: place });
});
