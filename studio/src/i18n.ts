// The page's sentences in the language that is chosen. A language is a file in `languages`; a test (xtask) finds a missing key.
import en from "./languages/en.json";
import { language } from "./settings";

export type Key = keyof typeof en;
type Texts = Record<Key, string>;

const FILES: Record<string, Texts> = import.meta.glob<Texts>("./languages/*.json", { eager: true, import: "default" });

/** By the name of the file: `en`, `zh`. */
export const LANGUAGES = new Map(Object.entries(FILES).map(([path, texts]) => [path.replace(/^.*\/|\.json$/g, ""), texts]));

/** A sentence, with what stands in braces replaced. */
export function t(key: Key, values: Record<string, string | number> = {}): string {
  const text = LANGUAGES.get(language.value)?.[key] ?? en[key];
  return text.replace(/\{(\w+)\}/g, (all, name: string) => String(values[name] ?? all));
}

/** A sentence if the page has it, else what the station says. */
export const told = (key: string, or: string): string => (key in en ? t(key as Key) : or);
