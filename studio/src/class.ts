// Class: the identity of this page in it, whose turn it is, and who waits for a turn.
import { computed, effect, signal } from "@preact/signals";
import type { Result } from "./client";
import { t } from "./i18n";
import { formatDuration } from "./run/jobs";
import { call, notificationListeners, showArm } from "./session";
import * as store from "./store";

type Turns = Result<"turn.list">;
export type ArmTurn = Turns["arms"][number];
export type Place = Turns["queue"][number];
/** Turns of the class; null without a class. */
export const turns = signal<Turns | null>(null);
/**
 * True if there is a class; null until the station has said so. A hub is asked for the class
 * itself.
 */
export const classExists = signal<boolean | null>(null);
export const hasClass = computed(() => classExists.value === true);
/**
 * Time at which `turns` arrived, and its age in s: the remaining time of a turn counts from then.
 */
let turnsReceivedAt = 0;
const turnsAge = signal(0);
setInterval(
  () => (turnsAge.value = turns.value === null ? 0 : Math.floor((performance.now() - turnsReceivedAt) / 1000)),
  1000,
);

/** Name and code from the QR code of a slip. The sign-in form is filled in with them. */
export const fromSlip = signal<{ name: string; code: string } | null>(null);
export function readSlip(query: URLSearchParams): void {
  const [name, code] = [query.get("name"), query.get("code")];
  if (name !== null && code !== null) fromSlip.value = { name: name.slice(0, 40), code: code.slice(0, 12) };
}
// On a shared tablet the next pupil must not find the code in the form.
effect(() => void (store.pupil.value !== null && (fromSlip.value = null)));

function onTurns(told: Turns): void {
  turnsReceivedAt = performance.now();
  turnsAge.value = 0;
  classExists.value = told.turn_s !== null;
  turns.value = told.turn_s === null && !told.arms.some(({ frozen }) => frozen) ? null : told;
}

const onNoClass = (): void => {
  turns.value = null;
  classExists.value = false;
};
// A station without classes does not know the method.
effect(() => {
  // After a station is lost or has closed this page, its class is assumed to exist still.
  if (store.backend.value !== "station") classExists.value = null;
  turns.value = null;
  if (store.socket.value !== "up" || store.session.value === null) return;
  // At a hub the role changes when a class begins or ends at a station.
  if (store.hub.value && store.role.value)
    call("class.get", {}).then((told) => (classExists.value = told.class !== null), onNoClass);
  else call("turn.list", {}).then(onTurns, onNoClass);
});
notificationListeners.add((method, params) => {
  if (method === "turn.changed") onTurns(params);
  if (method === "turn.ending" && isMyName(params.person))
    store.notify(t("class.ending", { arm: params.arm, left: formatDuration(params.left_s) }));
  if (method !== "turn.granted") return;
  showArm(params.arm);
  store.notify(t("class.granted", { arm: params.arm }));
});

effect(() => {
  if (store.backend.value !== "station")
    store.audience.value = store.backend.value === "none" ? store.audience.peek() : "all";
  else if (store.refused.value === "token" && store.pupil.value === null) store.audience.value = "door";
  else if (store.pupil.value !== null) store.audience.value = "pupil";
  // While a lost station is searched for, the page keeps its layout.
  else if (classExists.value !== null)
    store.audience.value = classExists.value && store.role.value === "viewer" ? "door" : "all";
});

/** Remaining time of a turn, s; null if turns are not limited. */
export const remainingSeconds = (turn: ArmTurn): number | null =>
  turn.left_s === null ? null : turn.left_s - (turn.state === "running" && !turn.frozen ? turnsAge.value : 0);
const turnsByArm = computed(() => new Map(turns.value?.arms.map((turn) => [turn.arm, turn])));
export const turnOfArm = (arm: string): ArmTurn | null => turnsByArm.value.get(arm) ?? null;

/**
 * True if programs wait in the queue of their arm, as in a class, and go to no arm that a pupil
 * has.
 */
export const queuesPrograms = computed(() => turns.value !== null || (store.hub.value && hasClass.value));
/** Frozen arms. The same array until one changes, so that other tiles are not rendered again. */
export const frozen = computed((): readonly string[] => JSON.parse(frozenNames.value));
type ArmEntry = { name?: string; arm?: string; frozen?: boolean };
const frozenNames = computed(() =>
  JSON.stringify(
    (store.hub.value ? store.arms.value : (turns.value?.arms ?? []))
      .filter((one) => one.frozen)
      .map((one: ArmEntry) => one.name ?? one.arm),
  ),
);

effect(() => void (store.isFrozen.value = frozen.value.includes(store.armName.value ?? "")));

/** Describes a turn: whose it is and how long it lasts; a frozen arm is named first. */
export const turnStatusText = (arm: string): string | null =>
  turnOfArm(arm)?.frozen ? t("class.frozen") : turnText(arm);

export function turnText(arm: string): string | null {
  const turn = turnOfArm(arm);
  if (!turn?.person) return null;
  const left = remainingSeconds(turn);
  return `${t(`class.${turn.state as "running"}`, { name: turn.person })}${left === null ? "" : ` ${formatDuration(left)}`}`;
}

/** Formats a time of the station, Unix s, as wall time, with the day unless it is today. */
export function formatTime(unix: number): string {
  const at = new Date(unix * 1000);
  const isToday = at.toDateString() === new Date().toDateString();
  return at.toLocaleString(t("language.tag"), {
    hour: "2-digit",
    minute: "2-digit",
    ...(isToday ? {} : { weekday: "short", day: "numeric", month: "short" }),
  });
}

/** Name under which this page takes turns: a pupil's, or that of a student's token. */
const myName = computed(() => store.pupil.value ?? (store.role.value === "student" ? store.ownerName.value : null));
/** Arms that a pupil may get: all except those reserved for the teacher. */
export const myArms = computed(() =>
  (turns.value?.arms ?? []).filter(({ slot }) => slot == null || slot.until !== null).map(({ arm }) => arm),
);
/** True if this is the name of the pupil at this page. Case is ignored, as by the station. */
export const isMyName = (person: string | null): boolean =>
  person !== null && person.toLowerCase() === myName.value?.toLowerCase();
const isMe = ({ person }: { person: string | null }) => isMyName(person);
/** Turn or place in the queue of the signed-in pupil. */
export const myTurn = computed(() => turns.value?.arms.find(isMe) ?? null);
export const myPlace = computed(() => turns.value?.queue.find(isMe) ?? null);
export const myStatusText = computed(() => {
  if (myTurn.value !== null) return `${myTurn.value.arm}: ${turnStatusText(myTurn.value.arm)}`;
  return myPlace.value === null ? null : t("class.place", { n: myPlace.value.place });
});

/** True if the stop button stops all arms: where all are shown, and for a pupil without an arm. */
export const stopsAll = computed(() =>
  store.audience.value === "pupil"
    ? myTurn.value === null
    : store.arms.value.length > 1 && (store.route.value === "class" || store.route.value === "arms"),
);
