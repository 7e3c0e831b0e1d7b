// Moving by hand: hold and step. At most one jog at a time, held by a pointer or a key.
import { computed, effect, signal } from "@preact/signals";
import { reportError } from "./actions";
import type { Params } from "./client";
import { t } from "./i18n";
import { call, jogLine, notificationListeners, shownArm } from "./session";
import * as store from "./store";
import { type Target, target } from "./view/layers";

/**
 * Time after which a jog ends without a keep-alive, ms. With the grace time and the way to the arm
 * it is less than 300 ms.
 */
const KEEP_ALIVE_TIMEOUT = 230;
/** Grace time that the station adds, ms. */
const STATION_GRACE = 50;
/** Interval of the page's signs of life to the worker, ms. */
const HEARTBEAT_INTERVAL = 50;

/** Shortest step whose target is shown in the picture, mm: a shorter one ends before it is seen. */
const MIN_SHOWN_STEP = 10;

export type Axis = Params<"jog.step">["axis"];
export const FRAMES = ["base", "joint", "tool"] as const;
export type Frame = (typeof FRAMES)[number];
export const STEPS = [0.1, 1, 5, 10, 50] as const;

export const mode = signal<"hold" | "step">("hold");
export const frame = signal<Frame>("base");
export const stepSize = signal<number>(5);
export const speed = signal(50);
export const phase = signal<"idle" | "running" | "ending">("idle");
/** Current axis and direction, such as `x+`. */
export const currentDirection = signal<string | null>(null);
/** Reason for the end of the last jog. */
export const endReason = signal<string | null>(null);
/** True if a press makes a step. Jogs have no tool frame, so there it always does. */
export const makesSteps = computed(() => mode.value === "step" || frame.value === "tool");

let holder: unknown = null;
let heartbeat: ReturnType<typeof setInterval> | undefined;
let jogId: string | null = null;
let jogNumber = 0;

/** Handles the press of a button or key, identified by `by`. */
export function press(axis: Axis, sign: 1 | -1, by: unknown): void {
  if (store.why.value !== null) {
    store.notify(t(store.why.value), true);
    return;
  }
  if (makesSteps.value) void makeStep(axis, sign);
  else void startHold(axis, sign, by);
}

/** Handles its release: ends the jog that it holds. */
export function release(by: unknown): void {
  if (by === holder) endJog("released");
}

/** Ends the current jog, if there is one. */
export function endJog(why: "released" | "stopped"): void {
  if (phase.value !== "running") return;
  clearInterval(heartbeat);
  holder = null;
  jogLine.release();
  phase.value = "ending";
  endReason.value = why;
  const mine = jogNumber;
  // The answer to the stop may be lost with the connection.
  setTimeout(() => mine === jogNumber && phase.value === "ending" && onJogEnd(), 1500);
}

function onJogEnd(): void {
  clearInterval(heartbeat);
  holder = null;
  jogId = null;
  phase.value = "idle";
  currentDirection.value = null;
}

async function startHold(axis: Axis, sign: 1 | -1, by: unknown): Promise<void> {
  endJog("released");
  const mine = ++jogNumber;
  const direction = `${axis}${sign > 0 ? "+" : "-"}` as Params<"jog.start">["axis"];
  holder = by;
  jogId = null;
  phase.value = "running";
  currentDirection.value = direction;
  endReason.value = null;
  clearInterval(heartbeat);
  heartbeat = setInterval(() => jogLine.alive(), HEARTBEAT_INTERVAL);
  try {
    const params = { ...shownArm(), axis: direction, keep_ms: KEEP_ALIVE_TIMEOUT, percent: speed.value };
    const { jog } = await jogLine.jog(params, KEEP_ALIVE_TIMEOUT / 4, KEEP_ALIVE_TIMEOUT + STATION_GRACE);
    if (mine === jogNumber) jogId = jog;
  } catch (error) {
    if (mine !== jogNumber) return;
    // The jog was released before it began, so this is not an error.
    const released = phase.value !== "running";
    onJogEnd();
    if (!released) reportError(error);
  }
}

let isStepping = false;
async function makeStep(axis: Axis, sign: 1 | -1): Promise<void> {
  // One step at a time: presses during a step are dropped, not queued.
  if (isStepping) return;
  isStepping = true;
  currentDirection.value = `${axis}${sign > 0 ? "+" : "-"}`;
  let aim: Target | undefined;
  try {
    const ofTool = frame.value === "tool" && ["x", "y", "z", "r"].includes(axis);
    const by = sign * stepSize.value;
    const state = store.state.value;
    if (state !== null && Math.abs(by) >= MIN_SHOWN_STEP && (axis === "x" || axis === "y" || axis === "z") && !ofTool) {
      const { x, y, z, r } = state;
      aim = { x, y, z, r, [axis]: state[axis] + by };
      target.value ??= aim;
    }
    await call("jog.step", {
      ...shownArm(),
      axis,
      by,
      percent: speed.value,
      ...(ofTool ? { frame: "tool" as const } : {}),
    });
    endReason.value = null;
  } catch (error) {
    reportError(error);
  } finally {
    isStepping = false;
    currentDirection.value = null;
    if (target.value === aim) target.value = null;
  }
}

notificationListeners.add((method, params) => {
  if (method !== "jog.ended" || params.arm !== store.armName.value) return;
  if (phase.value === "idle") return;
  // The end of a replaced jog does not concern the current one.
  if (params.why === "replaced" || (jogId !== null && params.jog !== jogId)) return;
  if (phase.value === "running" && jogId === null) return;
  // If the user did not release it, the worker ended it because the page was busy for too long.
  const why = params.why === "released" && phase.value === "running" ? "not-kept" : params.why;
  if (why !== "released" || endReason.value === null) endReason.value = why;
  onJogEnd();
});
effect(() => {
  if (store.socket.value !== "up" && phase.peek() !== "idle") {
    endReason.value = "link";
    onJogEnd();
  }
});

/** Selects the next or previous step size; the ends of the list stay. */
export function changeStepSize(by: 1 | -1): void {
  const at = STEPS.indexOf(stepSize.value as (typeof STEPS)[number]) + by;
  stepSize.value = STEPS[Math.max(0, Math.min(STEPS.length - 1, at))] ?? stepSize.value;
}
export function changeSpeed(by: 1 | -1): void {
  speed.value = Math.max(1, Math.min(100, Math.round((speed.value + 10 * by) / 10) * 10));
}
export function nextFrame(): void {
  frame.value = FRAMES[(FRAMES.indexOf(frame.value) + 1) % FRAMES.length] ?? "base";
}

// A jog ends as soon as its user cannot see or reach the page.
addEventListener("blur", () => endJog("released"));
addEventListener("hashchange", () => endJog("released"));
addEventListener("pagehide", () => endJog("released"));
addEventListener("contextmenu", () => endJog("released"));
document.addEventListener("freeze", () => endJog("released"));
document.addEventListener("visibilitychange", () => document.hidden && endJog("released"));
