// A code of six digits, which a station shows its owner, becomes a token for this tablet.
import { ownName } from "./settings";

/** Six digits in the place of a token: a teacher's PIN, as `tokenFor` has made a token of a code. */
export const isPin = (token: string): boolean => /^\d{6}$/.test(token);

/** Whether the station is on this computer, where a teacher has a PIN and nobody needs a code. */
const isHere = (api: string): boolean => ["localhost", "127.0.0.1", "[::1]"].includes(new URL(api).hostname);

/** The token for what was typed: a token as it is, a code after asking the station for one; null when it refuses. On this computer six digits are a PIN. */
export async function tokenFor(api: string, typed: string): Promise<string | null> {
  if (!isPin(typed) || isHere(api)) return typed;
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
