// Wall time of what a station says: the clock of the page's own virtual arm runs ahead of it, or stands still.
import * as store from "./store";

/** From when on by the clock of that arm, Unix s, it is how far ahead, s; the newest last. */
const jumps: Array<{ from: number; ahead: number }> = [];

export const jumped = (from: number, ahead: number): void => void jumps.push({ from, ahead });

/** When it was, of a time that the connected station said, Unix s. */
export function wallTime(said: number): Date {
  const jump = store.backend.peek() === "sim" ? jumps.findLast(({ from }) => from <= said) : undefined;
  return new Date(1000 * (said - (jump?.ahead ?? 0)));
}
