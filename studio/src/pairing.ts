// A code of six digits, which a station shows its owner, becomes a token for this tablet.
import { ownName } from "./settings";

/** The token for what was typed: a token as it is, a code after asking the station for one; null when it refuses. */
export async function tokenFor(api: string, typed: string): Promise<string | null> {
  if (!/^\d{6}$/.test(typed)) return typed;
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
