// Reasons why pupils and their programs wait, as text.
import { formatTime, type Place } from "../../class";
import { isWord, w } from "./words";

/** Reason why a program waits; an unknown reason is shown as received. */
export function reasonOf(reason: string | null): string {
  const key = `class.reason.${reason ?? "front"}`;
  return isWord(key) ? w(key) : String(reason);
}

/**
 * Additional reason why a pupil at this place waits, beyond the turns before; null if there is
 * none.
 */
export function whyWaits({ reason, from }: Place): string | null {
  if (!reason) return null;
  return reason === "schedule" && from !== null
    ? w("class.wait.from", { time: formatTime(from) })
    : w(`class.wait.${reason}`);
}
