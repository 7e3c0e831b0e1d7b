// Settings of the user, stored in this browser only.
import { effect, type Signal, signal } from "@preact/signals";

export type Storage = "localStorage" | "sessionStorage";

/** Stored value under a name; null if there is no value or the browser permits no storage. */
export function readValue(of: Storage, name: string): string | null {
  try {
    return globalThis[of].getItem(`magician.${name}`);
  } catch {
    return null;
  }
}
/** Stores a value, or deletes it if it is null, if the browser permits it. */
export function writeValue(of: Storage, name: string, value: string | null): void {
  try {
    if (value === null) globalThis[of].removeItem(`magician.${name}`);
    else globalThis[of].setItem(`magician.${name}`, value);
  } catch {
    // Without storage the value lasts until the page is closed.
  }
}

/** Returns a stored value that matches a pattern. Other values are removed. */
export function readMatching(of: Storage, name: string, shape: RegExp): string | null {
  const value = readValue(of, name);
  if (value === null || shape.test(value)) return value;
  writeValue(of, name, null);
  return null;
}

/** Set with or without a member. */
export const withMember = <T>(set: ReadonlySet<T>, member: T, is: boolean): ReadonlySet<T> =>
  new Set(is ? [...set, member] : [...set].filter((one) => one !== member));

function storedSetting<T extends string>(name: string, usual: T, takes: (value: string) => boolean): Signal<T> {
  const value = readValue("localStorage", name) ?? usual;
  const made = signal<T>((takes(value) ? value : usual) as T);
  effect(() => writeValue("localStorage", name, made.value === usual ? null : made.value));
  return made;
}

export const THEMES = ["system", "light", "dark"] as const;
export type Theme = (typeof THEMES)[number];

/** Language of the page. A language without a translation falls back to English (`i18n.ts`). */
export const language = storedSetting("language", navigator.language.slice(0, 2).toLowerCase(), (value) =>
  /^[a-z]{2}$/.test(value),
);
export const theme = storedSetting<Theme>("theme", "system", (value) => (THEMES as readonly string[]).includes(value));
export const ownName = storedSetting<string>("name", "", (value) => value.length <= 40);
/** Arm that was shown last. */
export const lastArm = storedSetting<string>("arm", "", () => true);
/** Connection to restore after a reload. */
export const lastBackend = storedSetting<"none" | "sim">("used", "none", (value) => value === "sim");
/** True after the first steps were closed. */
export const hasTried = storedSetting<"no" | "yes">("tried", "no", (value) => value === "yes");

effect(() => {
  const root = document.documentElement;
  if (theme.value === "system") delete root.dataset.theme;
  else root.dataset.theme = theme.value;
});
