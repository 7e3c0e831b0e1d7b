// The page's sentences in the language that is chosen. A language is a file; a missing key does not compile.
import { en } from "./en";
import { language } from "./settings";
import { zh } from "./zh";

export type Key = keyof typeof en;
export type Texts = Record<Key, string>;

const LANGUAGES: Record<string, Texts> = { en, zh };

/** A sentence, with what stands in braces replaced. */
export function t(key: Key, values: Record<string, string | number> = {}): string {
  const text = LANGUAGES[language.value]?.[key] ?? en[key];
  return text.replace(/\{(\w+)\}/g, (all, name: string) => String(values[name] ?? all));
}
