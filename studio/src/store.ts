// What the page knows: one place for all of it. `session.ts` changes it, the panels show it.
import { computed, effect, signal } from "@preact/signals";
import type { Holder, Methods, State } from "./api";

/** At a hub with the machine of the arm, as far as it is known, and whether it is frozen. */
export type ArmEntry = Methods["arm.list"]["result"]["arms"][number] & { machine?: string; frozen?: boolean };
export type Model = Methods["arm.model"]["result"];
export type Alarm = NonNullable<Methods["arm.alarms"]["result"]["alarms"]>[number];
export type Fence = Methods["arm.fence"]["result"]["fence"];

export type Route =
  | "move"
  | "gallery"
  | "teach"
  | "draw"
  | "engrave"
  | "run"
  | "io"
  | "plots"
  | "world"
  | "class"
  | "arms"
  | "settings";
export const ROUTES: readonly Route[] = [
  "move",
  "gallery",
  "teach",
  "draw",
  "engrave",
  "run",
  "io",
  "plots",
  "world",
  "class",
  "arms",
  "settings",
];
/** Routes of people in front of whom a class has its door: look on and sign in. */
const AT_DOOR: readonly Route[] = ["class", "move", "arms", "settings"];
/** Routes of pupils, in the order of a lesson. */
const OF_PUPILS: readonly Route[] = ["class", "draw", "teach", "run", "move"];
/** Not in a pupil's frame, and shown where its address is opened: with a laser that pupils may use. */
const HIDDEN_OF_PUPILS: readonly Route[] = ["engrave"];

/** How the station is reached: `none` before anything is chosen. */
export const backend = signal<"none" | "sim" | "station" | "serial">("none");
/** How fast the page's virtual arm is: `?speed=N`. */
export const simSpeed = Math.max(1, Math.min(100, Number(new URLSearchParams(location.search).get("speed")) || 1));
/** Whether the page is of files, without a station behind it. */
export const isStatic = signal(false);
/** A newer build of the page is there: a press takes it. */
export const update = signal<(() => void) | null>(null);
/** `lost`: it was there, and is looked for; `closed`: it is not looked for. */
export const socket = signal<"closed" | "connecting" | "up" | "lost">("closed");
export const since = signal<Date | null>(null);
/** Why the page is not let in: a token is wanted, another page took the session over, all places are taken. */
export const refused = signal<"token" | "revoked" | "taken" | "full" | "unreachable" | null>(null);
/** What the station said of a name, code or PIN that it did not take; a hub says at which `machines` pupils sign in. */
export const signInFault = signal<{ of: "pupil" | "pin"; wait: unknown; machines: unknown } | null>(null);
/** Why the serial port did not lead to an arm. */
export const portFault = signal<"busy" | "gone" | "silent" | "died" | "denied" | null>(null);

/** The subscription to the shown arm. */
export const subscription = signal<number | null>(null);
export const session = signal<string | null>(null);
export const role = signal<"viewer" | "student" | "teacher">("viewer");
/** Whether a hub answers: pupils, turns and codes are at the pages of its stations. */
export const hub = signal(false);
/** The name of the session. */
export const ownerName = signal("");
/** Who is signed in as a pupil of a class. */
export const pupil = signal<string | null>(null);
/** For whom the page is made up: `door` for people whom a class does not know yet. `class.ts` says it. */
export const audience = signal<"all" | "door" | "pupil">("all");
/** The address behind the `#` of the page. */
export const wanted = signal("");
/** As they stand in the page's frame. */
export const routes = computed<readonly Route[]>(() => {
  if (audience.value !== "all") return audience.value === "door" ? AT_DOOR : OF_PUPILS;
  return backend.value === "station" ? ROUTES : ROUTES.filter((one) => one !== "class");
});
export const route = computed<Route>(() => {
  const shown = audience.value === "pupil" ? [...routes.value, ...HIDDEN_OF_PUPILS] : routes.value;
  return shown.find((one) => one === wanted.value) ?? shown[0] ?? "move";
});
export const arms = signal<ArmEntry[]>([]);
export const armName = signal<string | null>(null);
export const state = signal<State | null>(null);
/** When the last state came, by the page's clock. */
export const heardAt = signal(0);
export const stale = signal(true);
export const model = signal<Model | null>(null);
export const alarms = signal<Alarm[]>([]);
/** Code of the alarm of an arm that was switched on, or whose controller was reset: nothing is wrong with it. */
export const SWITCHED_ON = 0;
export const fence = signal<Fence>(null);
/** Whether a teacher has frozen the shown arm: `class.ts` says it. */
export const isFrozen = signal(false);
/** The arm that homes because this page has said so. */
export const homing = signal<string | null>(null);
export const jobState = signal<string>("none");
/** Those who ask for control. */
export const asked = signal<(Holder & { message?: string | null }) | null>(null);
/** Whether this page has asked, and waits. */
export const asking = signal(false);

export const arm = computed(() => arms.value.find((entry) => entry.name === armName.value) ?? null);
export const isUp = computed(() => socket.value === "up" && state.value?.link === "up");
export const link = computed<"up" | "lost" | "closed">(() => {
  if (isUp.value) return "up";
  if (socket.value === "lost" || (socket.value === "up" && state.value?.link === "lost")) return "lost";
  return "closed";
});
export const holder = computed<Holder | null>(() => (socket.value === "up" ? (arm.value?.holder ?? null) : null));
export const lease = computed<"mine" | "other" | "free">(() => {
  if (holder.value === null) return "free";
  return holder.value.session === session.value ? "mine" : "other";
});
export const isHomed = computed(() => state.value?.homed ?? null);
export const holds = computed(() => alarms.value.some((alarm) => alarm.holds_queue));
/** States of a job in which it has the arm. */
const BUSY = ["checking", "running", "pausing", "stopping"];
export const isBusy = computed(() => BUSY.includes(jobState.value));

/** What an arm does that goes on by itself: its laser, by hand or in a job, and its way. */
interface Doing {
  arm: string;
  laser: boolean;
  moves: boolean;
}
const isLit = computed(() => state.value?.tool?.laser === true);
const doing = signal<Doing | null>(null);
effect(() => {
  if (!isUp.value || state.value === null) return;
  const before = doing.peek();
  const arm = state.value.arm;
  // A job has the laser off on its way from line to line.
  const laser = isLit.value || (isBusy.value && before?.laser === true && before.arm === arm);
  const moves = state.value.moving || isBusy.value;
  // The page's own virtual arm ends with its station.
  if (backend.value === "sim") doing.value = null;
  else if (before === null || before.arm !== arm || before.laser !== laser || before.moves !== moves)
    doing.value = { arm, laser, moves };
});
/** What the shown arm did by the last word of it, as long as nothing newer is heard: it may still do that. Null while it is heard. */
export const left = computed<Doing | null>(() => {
  const last = doing.value;
  if (isUp.value || last === null || !(last.laser || last.moves)) return null;
  return armName.value === null || armName.value === last.arm ? last : null;
});
/** `unknown`: it was on by the last word of it. */
export const laser = computed<"on" | "off" | "unknown">(() =>
  isUp.value ? (isLit.value ? "on" : "off") : left.value?.laser === true ? "unknown" : "off",
);

/** Why somebody can do nothing to an arm, as a key of the texts; `isThere` is whether it is reached. */
export function barred(isThere: boolean) {
  const isOver = refused.value === "revoked" && pupil.value !== null;
  if (socket.value === "closed") return isOver ? ("closed.class" as const) : ("why.closed" as const);
  if (!isThere) return "why.lost" as const;
  if (role.value === "viewer") return audience.value === "door" ? ("why.door" as const) : ("why.viewer" as const);
  // A teacher moves what is frozen.
  if (isFrozen.value && role.value === "student") return "why.frozen" as const;
  if (lease.value === "mine") return null;
  if (audience.value === "pupil") return "why.turn" as const;
  // The page of the class has no buttons for it.
  if (route.value === "class") return "why.there" as const;
  return lease.value === "other" ? ("why.other" as const) : ("why.free" as const);
}
const whileBusy = () => {
  if (homing.value !== null && homing.value === armName.value) return "why.homing" as const;
  return isBusy.value ? ("why.busy" as const) : null;
};
/** Why nothing can be moved now. */
export const why = computed(() => barred(isUp.value) ?? whileBusy());

/** A sentence that passes: what was refused, and why. */
export const notice = signal<{ text: string; bad: boolean } | null>(null);
let noticeEnds: ReturnType<typeof setTimeout> | undefined;
export function say(text: string, bad = false): void {
  notice.value = { text, bad };
  clearTimeout(noticeEnds);
  noticeEnds = setTimeout(() => (notice.value = null), bad ? 12_000 : 5_000);
}

// What was said of an arm that could not be reached, or was frozen, holds no more when it can be moved.
const isHeld = computed(() => socket.value !== "up" || isFrozen.value);
effect(() => {
  if (!isHeld.value && notice.peek()?.bad) notice.value = null;
});

/** A question that waits for yes or no. */
export interface Question {
  title: string;
  text: string;
  yes: string;
  answer: (yes: boolean) => void;
}
export const question = signal<Question | null>(null);
export function ask(title: string, text: string, yes: string): Promise<boolean> {
  question.value?.answer(false);
  return new Promise((done) => {
    const answer = (is: boolean) => {
      question.value = null;
      done(is);
    };
    question.value = { title, text, yes, answer };
  });
}
/** Asks for the person's own name, once a tab; answered with null if none is given. */
export const naming = signal<((name: string | null) => void) | null>(null);
export const showsKeys = signal(false);
/** What is open beside the panel, on every route. */
export type Beside = "help" | "tour";
export const beside = signal<Beside | null>(null);
