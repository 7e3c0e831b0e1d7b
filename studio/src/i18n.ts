// Sentences of the page in the selected language. Each language is a file in `languages`; a test
// (xtask) reports missing keys.
import { effect, signal } from "@preact/signals";
import en from "./languages/en.json";
import { language } from "./settings";

export type Key = keyof typeof en;
type Texts = Record<Key, string>;

const FILES = import.meta.glob<Texts>("./languages/*.json", { import: "default" });
/** Translations of the station's sentences, by their English templates. */
const STATION_TEXTS = import.meta.glob<Texts>("./said/*.json", { import: "default" });
const fileOf = (name: string) => `./languages/${name}.json`;

/** Languages by file name and by their own name: `zh`, `中文`. */
export const LANGUAGES = Object.keys(FILES).map((path) => {
  const value = path.replace(/^.*\/|\.json$/g, "");
  return { value, text: new Intl.DisplayNames(value, { type: "language" }).of(value) ?? value };
});

/** English is part of the page; other languages are loaded when selected. */
const texts = signal<Texts>(en);
effect(() => {
  const name = language.value;
  const load = name === "en" ? undefined : FILES[fileOf(name)];
  if (load === undefined) return void (texts.value = en);
  Promise.all([load(), STATION_TEXTS[`./said/${name}.json`]?.()]).then(
    ([loaded, said]) => {
      if (language.peek() === name) texts.value = { ...said, ...loaded };
    },
    () => {},
  );
});

/** Sentence of a key, with values in place of the braces. */
export function t(key: Key, values: Record<string, string | number> = {}): string {
  return interpolate(texts.value[key] ?? en[key] ?? key, values);
}

export const interpolate = (text: string, values: Record<string, string | number>): string =>
  text.replace(/\{(\w+)\}/g, (all, name: string) => String(values[name] ?? all));

/** Translation of a key, or the station's own English text. */
export const translated = (key: string, or: string): string => (texts.value as Record<string, string>)[key] ?? or;

/** Sentence of the station as data: its English template with the values. */
export interface Sentence {
  template?: string;
  values?: readonly Value[];
}
interface Value extends Sentence {
  name: string;
  text?: string;
  option?: string;
}

/** Name of an option. Panels that ask for options replace it, since they know more names. */
export const names = { option: (name: string): string => translated(`setup.${name}`, name) };

const sentenceText = ({ template = "", values = [] }: Sentence): string =>
  interpolate(
    translated(template, template),
    Object.fromEntries(
      values.map((value) => [
        value.name,
        value.text ?? (value.option === undefined ? sentenceText(value) : `“${names.option(value.option)}”`),
      ]),
    ),
  );

/** Sentence of the station in the page's language, with the names that options have there. */
export const sentence = (of: Sentence): string =>
  sentenceText(of).replace(/^[a-z](?=[a-z])/, (first) => first.toUpperCase());
