// What the page keeps of its person, in this browser alone.
import { effect, signal, type Signal } from "@preact/signals";

function kept<T extends string>(key: string, usual: T, takes: (value: string) => boolean): Signal<T> {
  let value: string = usual;
  try {
    value = localStorage.getItem(`magician.${key}`) ?? usual;
  } catch {
    // A browser that keeps nothing has the usual values.
  }
  const made = signal<T>((takes(value) ? value : usual) as T);
  effect(() => {
    const now = made.value;
    try {
      if (now === usual) localStorage.removeItem(`magician.${key}`);
      else localStorage.setItem(`magician.${key}`, now);
    } catch {
      // The same.
    }
  });
  return made;
}

export type Theme = "system" | "light" | "dark";

/** A language that the page has no file of is English (`i18n.ts`). */
export const language = kept("language", navigator.language.slice(0, 2).toLowerCase(), (value) => /^[a-z]{2}$/.test(value));
export const theme = kept<Theme>("theme", "system", (value) => ["system", "light", "dark"].includes(value));
export const ownName = kept<string>("name", "", (value) => value.length <= 40);
/** The arm that was shown last. */
export const lastArm = kept<string>("arm", "", () => true);
/** What is opened again after a reload. */
export const used = kept<"none" | "sim">("used", "none", (value) => value === "sim");
/** Whether the first steps were closed. */
export const hasTried = kept<"no" | "yes">("tried", "no", (value) => value === "yes");

effect(() => {
  const root = document.documentElement;
  if (theme.value === "system") delete root.dataset["theme"];
  else root.dataset["theme"] = theme.value;
});
