// Wall time of a station's times: the clock of the page's own virtual arm may run ahead of it or
// stand still.
import * as store from "./store";

/**
 * Jumps of the arm's clock: from which time on, Unix s by that clock, it is how far ahead, s.
 * Newest last.
 */
const jumps: Array<{ from: number; ahead: number }> = [];

export const recordJump = (from: number, ahead: number): void => void jumps.push({ from, ahead });

/** Converts a time of the connected station, Unix s, into wall time. */
export function wallTime(said: number): Date {
  const jump = store.backend.peek() === "sim" ? jumps.findLast(({ from }) => from <= said) : undefined;
  return new Date(1000 * (said - (jump?.ahead ?? 0)));
}
