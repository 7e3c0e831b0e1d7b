// State of the page as signals. `session.ts` changes it, the panels render it.
import { computed, effect, signal } from "@preact/signals";
import type { Holder, Methods, State } from "./api";

/** Entry of an arm. A hub adds its machine, if known, and whether it is frozen. */
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
/** Routes for a page that has not signed in to a class: view and sign in. */
const SIGNED_OUT_ROUTES: readonly Route[] = ["class", "move", "arms", "settings"];
/** Routes for pupils, in the order of a lesson. */
const PUPIL_ROUTES: readonly Route[] = ["class", "draw", "teach", "run", "move"];
/**
 * Routes not shown in a pupil's navigation but open by their address, for pupils who may use a
 * laser.
 */
const HIDDEN_PUPIL_ROUTES: readonly Route[] = ["engrave"];

/** Kind of station. `none` until one is chosen. */
export const backend = signal<"none" | "sim" | "station" | "serial">("none");
/** Speed factor of the page's virtual arm: `?speed=N`. */
export const simSpeed = Math.max(1, Math.min(100, Number(new URLSearchParams(location.search).get("speed")) || 1));
/** True if the page is served as static files, without a station. */
export const isStatic = signal(false);
/** Activates a newer build of the page; null without one. */
export const update = signal<(() => void) | null>(null);
/**
 * State of the connection. `lost`: a connection that is being restored; `closed`: no connection is
 * wanted.
 */
export const socket = signal<"closed" | "connecting" | "up" | "lost">("closed");
export const lostSince = signal<Date | null>(null);
/**
 * Reason for which the page is refused: a token is required, another page took the session over,
 * the station is full.
 */
export const refused = signal<"token" | "revoked" | "taken" | "full" | "unreachable" | null>(null);
/**
 * Refusal of a name, code or PIN by the station. A hub lists the `machines` at which pupils can
 * sign in.
 */
export const signInFault = signal<{ of: "pupil" | "pin"; wait: unknown; machines: unknown } | null>(null);
/** Reason for which no arm was reached at the serial port. */
export const portFault = signal<"busy" | "gone" | "silent" | "died" | "denied" | null>(null);

/** Subscription to the shown arm. */
export const subscription = signal<number | null>(null);
export const session = signal<string | null>(null);
export const role = signal<"viewer" | "student" | "teacher">("viewer");
/** True if a hub answers. Pupils, turns and codes are managed on the pages of its stations. */
export const hub = signal(false);
/** Name of the session's owner. */
export const ownerName = signal("");
/** Pupil who is signed in; null for everyone else. */
export const pupil = signal<string | null>(null);
/**
 * Users for whom the page is laid out: `door` for users not signed in to the class. Set by
 * `class.ts`.
 */
export const audience = signal<"all" | "door" | "pupil">("all");
/** Address after the `#`. */
export const hash = signal("");
/** Routes in the order of the navigation. */
export const routes = computed<readonly Route[]>(() => {
  if (audience.value !== "all") return audience.value === "door" ? SIGNED_OUT_ROUTES : PUPIL_ROUTES;
  return backend.value === "station" ? ROUTES : ROUTES.filter((one) => one !== "class");
});
export const route = computed<Route>(() => {
  const shown = audience.value === "pupil" ? [...routes.value, ...HIDDEN_PUPIL_ROUTES] : routes.value;
  return shown.find((one) => one === hash.value) ?? shown[0] ?? "move";
});
export const arms = signal<ArmEntry[]>([]);
export const armName = signal<string | null>(null);
export const state = signal<State | null>(null);
/** Time of the last state, by the page's clock. */
export const heardAt = signal(0);
export const stale = signal(true);
export const model = signal<Model | null>(null);
export const alarms = signal<Alarm[]>([]);
/** Code of the alarm after power-on or a reset of the controller. It indicates no fault. */
export const SWITCHED_ON = 0;
export const fence = signal<Fence>(null);
/** True if a teacher has frozen the shown arm; set by `class.ts`. */
export const isFrozen = signal(false);
/** Arm that is homing at the request of this page. */
export const homing = signal<string | null>(null);
export const jobState = signal<string>("none");
/** Session that requests control. */
export const controlRequest = signal<(Holder & { message?: string | null }) | null>(null);
/** True while a request of this page for control is pending. */
export const isRequestingControl = signal(false);

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
export const isQueueHeld = computed(() => alarms.value.some((alarm) => alarm.holds_queue));
/** States of a job in which it occupies the arm. */
const BUSY_STATES = ["checking", "running", "pausing", "stopping"];
export const isBusy = computed(() => BUSY_STATES.includes(jobState.value));

/** Activity of an arm that continues without the page: laser and motion. */
interface Activity {
  arm: string;
  laser: boolean;
  isMoving: boolean;
}
const isLit = computed(() => state.value?.tool?.laser === true);
const activity = signal<Activity | null>(null);
effect(() => {
  if (!isUp.value || state.value === null) return;
  const before = activity.peek();
  const arm = state.value.arm;
  // A job has the laser off on its way from line to line.
  const laser = isLit.value || (isBusy.value && before?.laser === true && before.arm === arm);
  const moves = state.value.moving || isBusy.value;
  // The page's own virtual arm ends with its station.
  if (backend.value === "sim") activity.value = null;
  else if (before === null || before.arm !== arm || before.laser !== laser || before.isMoving !== moves)
    activity.value = { arm, laser, isMoving: moves };
});
/** Last known activity of the shown arm while it is unreachable; null while it is heard. */
export const lastActivity = computed<Activity | null>(() => {
  const last = activity.value;
  if (isUp.value || last === null || !(last.laser || last.isMoving)) return null;
  return armName.value === null || armName.value === last.arm ? last : null;
});
/** `unknown`: last known to be on, and the arm is unreachable. */
export const laser = computed<"on" | "off" | "unknown">(() =>
  isUp.value ? (isLit.value ? "on" : "off") : lastActivity.value?.laser === true ? "unknown" : "off",
);

/**
 * Key of the text that says why an arm cannot be controlled; null if it can. `isThere` is true if
 * the arm is reached.
 */
export function whyBarred(isThere: boolean) {
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
const whyBusy = () => {
  if (homing.value !== null && homing.value === armName.value) return "why.homing" as const;
  return isBusy.value ? ("why.busy" as const) : null;
};
/** Reason for which nothing can be moved now; null if motion is possible. */
export const why = computed(() => whyBarred(isUp.value) ?? whyBusy());

/** Temporary message, such as a refusal with its reason. */
export const notice = signal<{ text: string; bad: boolean } | null>(null);
let noticeEnds: ReturnType<typeof setTimeout> | undefined;
export function notify(text: string, bad = false): void {
  notice.value = { text, bad };
  clearTimeout(noticeEnds);
  noticeEnds = setTimeout(() => (notice.value = null), bad ? 12_000 : 5_000);
}

// Notices of an unreachable or frozen arm expire once it can be moved.
const isBlocked = computed(() => socket.value !== "up" || isFrozen.value);
effect(() => {
  if (!isBlocked.value && notice.peek()?.bad) notice.value = null;
});

/** Question to be answered with yes or no. */
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
/** Asks for the user's name, once per tab. Answered with null if no name is given. */
export const namePrompt = signal<((name: string | null) => void) | null>(null);
export const showsKeys = signal(false);
/** Content opened beside the panel, on every route. */
export type SidePanel = "help" | "tour";
export const sidePanel = signal<SidePanel | null>(null);
