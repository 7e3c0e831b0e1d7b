// Exchanges a code of six digits, shown by the station to its owner, for a token of this tablet.
import { ownName } from "./settings";

/**
 * True for six digits in place of a token: the PIN of a teacher, since `tokenFor` has exchanged
 * codes before.
 */
export const isPin = (token: string): boolean => /^\d{6}$/.test(token);

/** True if the station is on this computer, where a teacher has a PIN and codes are not needed. */
const isLocal = (api: string): boolean => ["localhost", "127.0.0.1", "[::1]"].includes(new URL(api).hostname);

/**
 * Token for the typed text: a token is returned as it is, a code is exchanged at the station; null
 * if the station refuses. On this computer six digits are a PIN.
 */
export async function tokenFor(api: string, typed: string): Promise<string | null> {
  if (!isPin(typed) || isLocal(api)) return typed;
  const place = new URL("pair", api.replace(/^ws/, "http"));
  const body = JSON.stringify({ code: typed, name: ownName.value || "studio" });
  try {
    const answer = await fetch(place, { method: "POST", headers: { "content-type": "application/json" }, body });
    if (!answer.ok) return null;
    const { token } = (await answer.json()) as { token: string };
    return token;
  } catch {
    return null;
  }
}
