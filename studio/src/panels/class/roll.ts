// The class with its codes, as a teacher is told it: read again whenever somebody comes, goes or has a turn.
import { effect, signal } from "@preact/signals";
import { isOn } from "../../class";
import type { Result, Told } from "../../client";
import { call, notified } from "../../session";
import * as store from "../../store";

/** Of a hub with the arms of stations that have not answered, or have another class or none. */
export type Roll = Result<"class.get"> & { missing?: string[]; differ?: Array<{ arms: string[] }> };
export const roll = signal<Roll | null>(null);
/** A pupil who comes or goes without a turn is seen after this, ms. */
const LOOK = 2000;

export async function read(): Promise<void> {
  try {
    const told = await call("class.get", {});
    roll.value = told.class ? told : null;
    // No station tells a hub's page that a class begins or ends.
    if (store.hub.value) isOn.value = told.class !== null;
  } catch {
    // Of a station that is away the names stay.
  }
}

export function watchRoll(): () => void {
  const hear = (...[method]: Told) => {
    if (method === "turn.changed" || method === "session.changed") void read();
  };
  notified.add(hear);
  const end = effect(() => void (store.socket.value === "up" && read()));
  const timer = setInterval(() => document.hidden || void read(), LOOK);
  return () => {
    notified.delete(hear);
    end();
    clearInterval(timer);
  };
}
