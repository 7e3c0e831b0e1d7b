// Class with its codes, for a teacher; read again whenever a pupil comes, leaves or gets a turn.
import { effect, signal } from "@preact/signals";
import { classExists } from "../../class";
import type { Result, StationNotification } from "../../client";
import { call, notificationListeners } from "../../session";
import * as store from "../../store";

/** At a hub also the arms of stations that have not answered, or have another class or none. */
export type Roll = Result<"class.get"> & { missing?: string[]; differ?: Array<{ arms: string[] }> };
export const roll = signal<Roll | null>(null);
/** Interval of reading, ms: pupils who come or leave without a turn cause no notification. */
const READ_INTERVAL = 2000;

export async function readRoll(): Promise<void> {
  try {
    const told = await call("class.get", {});
    roll.value = told.class ? told : null;
    // Stations do not notify a hub's page of the beginning or end of a class.
    if (store.hub.value) classExists.value = told.class !== null;
  } catch {
    // Keep the names while the station is away.
  }
}

export function watchRoll(): () => void {
  const hear = (...[method]: StationNotification) => {
    if (method === "turn.changed" || method === "session.changed") void readRoll();
  };
  notificationListeners.add(hear);
  const end = effect(() => void (store.socket.value === "up" && readRoll()));
  const timer = setInterval(() => document.hidden || void readRoll(), READ_INTERVAL);
  return () => {
    notificationListeners.delete(hear);
    end();
    clearInterval(timer);
  };
}
