// Pins of the shown arm: functions and readings, while a panel needs them.
import { effect, signal } from "@preact/signals";
import type { Pin } from "./api";
import type { Params, Result } from "./client";
import { call, notificationListeners, shownArm } from "./session";
import * as store from "./store";

export type Io = Result<"arm.io">;
export type Row = Io["rows"][number];
export type Field = NonNullable<Row["sets"]>[number];

export const io = signal<Io | null>(null);
/** Readings of pins by address: a level, or counts. */
export const levels = signal<ReadonlyMap<number, number>>(new Map());

/** Readings per second: each pin takes a request on the arm's line. */
const READ_RATE = 10;
let watchers = 0;
let subscription: number | null = null;
let watchedPins = "";

/** Kind of control for a pin's function, in the arm's terms; null if unknown. */
export const watchKind = (function_: number) =>
  (io.value?.functions.find(({ value }) => value === function_)?.watch as Pin["kind"] | null | undefined) ?? null;

export function watchPins(): () => void {
  watchers++;
  const end = effect(() => {
    const arm = store.armName.value;
    if (!store.isUp.value || arm === null) {
      unsubscribe();
      return;
    }
    void refresh();
  });
  return () => {
    end();
    if (--watchers === 0) unsubscribe();
  };
}

function unsubscribe(): void {
  if (subscription !== null) void call("arm.unsubscribe", { subscription }).catch(() => {});
  subscription = null;
  watchedPins = "";
  io.value = null;
  levels.value = new Map();
}

/** Reads the functions of the pins, and watches those with readings. */
export async function refresh(): Promise<void> {
  const { arm } = shownArm();
  try {
    const seen = await call("arm.io", { arm });
    if (arm !== store.armName.value || watchers === 0) return;
    io.value = seen;
    const pins = seen.pins.flatMap(({ address, function: own }) => {
      const kind = watchKind(own);
      return kind === null ? [] : [{ kind, address }];
    });
    const wanted = `${arm} ${store.session.value} ${JSON.stringify(pins)}`;
    if (wanted === watchedPins) return;
    watchedPins = wanted;
    if (subscription !== null) void call("arm.unsubscribe", { subscription }).catch(() => {});
    subscription = null;
    levels.value = new Map();
    if (pins.length === 0) return;
    const made = await call("arm.subscribe", { arm, rate: READ_RATE, pins } satisfies Params<"arm.subscribe">);
    if (wanted === watchedPins && watchers > 0) subscription = made.subscription;
    else void call("arm.unsubscribe", { subscription: made.subscription }).catch(() => {});
  } catch {
    // After a lost line the watch starts again when it is back.
  }
}

notificationListeners.add((method, params) => {
  if (method !== "arm.state" || params.subscription !== subscription) return;
  const { pins } = params.state;
  if (pins) levels.value = new Map(pins.map(({ address, value }) => [address, value]));
});
