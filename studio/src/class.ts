// A class: who this page is to it, whose turn it is, and who waits for one.
import { computed, effect, signal } from "@preact/signals";
import type { Result } from "./client";
import { t } from "./i18n";
import { duration } from "./run/jobs";
import { call, notified, show } from "./session";
import * as store from "./store";

type Turns = Result<"turn.list">;
export type ArmTurn = Turns["arms"][number];
export type Place = Turns["queue"][number];
/** Null where there is no class. */
export const turns = signal<Turns | null>(null);
/** Null until the station has said whether it has a class. A hub is asked for the class itself. */
export const isOn = signal<boolean | null>(null);
export const hasClass = computed(() => isOn.value === true);
/** When they were told, and how long ago that is, s: what is left of a turn runs from there. */
let toldAt = 0;
const age = signal(0);
setInterval(() => (age.value = turns.value === null ? 0 : Math.floor((performance.now() - toldAt) / 1000)), 1000);

/** The name and code of a slip whose QR code was read; the door has them filled in. */
export const fromSlip = signal<{ name: string; code: string } | null>(null);
export function slip(query: URLSearchParams): void {
  const [name, code] = [query.get("name"), query.get("code")];
  if (name !== null && code !== null) fromSlip.value = { name: name.slice(0, 40), code: code.slice(0, 12) };
}
// A shared tablet: whoever comes next does not find the code in the door.
effect(() => void (store.pupil.value !== null && (fromSlip.value = null)));

function hear(told: Turns): void {
  toldAt = performance.now();
  age.value = 0;
  isOn.value = told.turn_s !== null;
  turns.value = told.turn_s === null && !told.arms.some(({ frozen }) => frozen) ? null : told;
}

const noClass = (): void => {
  turns.value = null;
  isOn.value = false;
};
// A station without classes does not know the method.
effect(() => {
  // A station that is lost, or closed this page, had a class as far as the page knows.
  if (store.backend.value !== "station") isOn.value = null;
  turns.value = null;
  if (store.socket.value !== "up" || store.session.value === null) return;
  // A class that begins or ends at a station changes the role at a hub.
  if (store.hub.value && store.role.value)
    call("class.get", {}).then((told) => (isOn.value = told.class !== null), noClass);
  else call("turn.list", {}).then(hear, noClass);
});
notified.add((method, params) => {
  if (method === "turn.changed") hear(params);
  if (method === "turn.ending" && isOwn(params.person))
    store.say(t("class.ending", { arm: params.arm, left: duration(params.left_s) }));
  if (method !== "turn.granted") return;
  show(params.arm);
  store.say(t("class.granted", { arm: params.arm }));
});

effect(() => {
  if (store.backend.value !== "station")
    store.audience.value = store.backend.value === "none" ? store.audience.peek() : "all";
  else if (store.refused.value === "token" && store.pupil.value === null) store.audience.value = "door";
  else if (store.pupil.value !== null) store.audience.value = "pupil";
  // While a lost station is looked for, the page stays made up as it is.
  else if (isOn.value !== null) store.audience.value = isOn.value && store.role.value === "viewer" ? "door" : "all";
});

/** What is left of a turn, s; null where turns have no end. */
export const leftOf = (turn: ArmTurn): number | null =>
  turn.left_s === null ? null : turn.left_s - (turn.state === "running" && !turn.frozen ? age.value : 0);
const turnsByArm = computed(() => new Map(turns.value?.arms.map((turn) => [turn.arm, turn])));
export const turnAt = (arm: string): ArmTurn | null => turnsByArm.value.get(arm) ?? null;

/** Whether a program waits in the queue of its arm, as in a class, and goes to no arm that a pupil has. */
export const queues = computed(() => turns.value !== null || (store.hub.value && hasClass.value));
/** The arms that are frozen: the same list until one changes, so that no other tile is drawn again. */
export const frozen = computed((): readonly string[] => JSON.parse(frozenNames.value));
type Freezable = { name?: string; arm?: string; frozen?: boolean };
const frozenNames = computed(() =>
  JSON.stringify(
    (store.hub.value ? store.arms.value : (turns.value?.arms ?? []))
      .filter((one) => one.frozen)
      .map((one: Freezable) => one.name ?? one.arm),
  ),
);

effect(() => void (store.isFrozen.value = frozen.value.includes(store.armName.value ?? "")));

/** A turn in words: whose, and how long it is still; that its arm is frozen goes before. */
export const wordsOf = (arm: string): string | null => (turnAt(arm)?.frozen ? t("class.frozen") : turnOf(arm));

export function turnOf(arm: string): string | null {
  const turn = turnAt(arm);
  if (!turn?.person) return null;
  const left = leftOf(turn);
  return `${t(`class.${turn.state as "running"}`, { name: turn.person })}${left === null ? "" : ` ${duration(left)}`}`;
}

/** A clock of the wall, for what the station says as seconds since 1970; on another day with the day. */
export function clockOf(unix: number): string {
  const at = new Date(unix * 1000);
  const isToday = at.toDateString() === new Date().toDateString();
  return at.toLocaleString(t("language.tag"), {
    hour: "2-digit",
    minute: "2-digit",
    ...(isToday ? {} : { weekday: "short", day: "numeric", month: "short" }),
  });
}

/** Under which name the asker takes turns: a pupil's, or that of a student's token. */
const me = computed(() => store.pupil.value ?? (store.role.value === "student" ? store.ownerName.value : null));
/** The arms that a pupil may ever have: all but those that are the teacher's alone. */
export const myArms = computed(() =>
  (turns.value?.arms ?? []).filter(({ slot }) => slot == null || slot.until !== null).map(({ arm }) => arm),
);
/** Whether a name is that of the pupil at this page, who may have typed it in other letters: the station takes them for the same. */
export const isOwn = (person: string | null): boolean =>
  person !== null && person.toLowerCase() === me.value?.toLowerCase();
const isMe = ({ person }: { person: string | null }) => isOwn(person);
/** The turn or the place of the pupil who is signed in. */
export const myTurn = computed(() => turns.value?.arms.find(isMe) ?? null);
export const myPlace = computed(() => turns.value?.queue.find(isMe) ?? null);
export const mine = computed(() => {
  if (myTurn.value !== null) return `${myTurn.value.arm}: ${wordsOf(myTurn.value.arm)}`;
  return myPlace.value === null ? null : t("class.place", { n: myPlace.value.place });
});

/** Whether the stop of this page is for all arms: where all are shown, and for a pupil who has none. */
export const stopsAll = computed(() =>
  store.audience.value === "pupil"
    ? myTurn.value === null
    : store.arms.value.length > 1 && (store.route.value === "class" || store.route.value === "arms"),
);
