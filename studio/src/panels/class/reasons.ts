// Why pupils and their programs wait, in words.
import { clockOf, type Place } from "../../class";
import { isWord, w } from "./words";

/** Why a program waits; a reason that the page does not know is said as it came. */
export function reasonOf(reason: string | null): string {
  const key = `class.reason.${reason ?? "front"}`;
  return isWord(key) ? w(key) : String(reason);
}

/** Why somebody at this place waits longer than for the turns before; null if for nothing else. */
export function whyWaits({ reason, from }: Place): string | null {
  if (!reason) return null;
  return reason === "schedule" && from !== null
    ? w("class.wait.from", { time: clockOf(from) })
    : w(`class.wait.${reason}`);
}
