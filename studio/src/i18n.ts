// The page's sentences in the language that is chosen. A language is a file in `languages`; a test (xtask) finds a missing key.
import { effect, signal } from "@preact/signals";
import en from "./languages/en.json";
import { language } from "./settings";

export type Key = keyof typeof en;
type Texts = Record<Key, string>;

const FILES = import.meta.glob<Texts>("./languages/*.json", { import: "default" });
/** The station's sentences in other languages, by their English templates. */
const SAID = import.meta.glob<Texts>("./said/*.json", { import: "default" });
const fileOf = (name: string) => `./languages/${name}.json`;

/** By the name of the file, and as its speakers call it: `zh`, `中文`. */
export const LANGUAGES = Object.keys(FILES).map((path) => {
  const value = path.replace(/^.*\/|\.json$/g, "");
  return { value, text: new Intl.DisplayNames(value, { type: "language" }).of(value) ?? value };
});

/** English comes with the page, another language when it is chosen. */
const texts = signal<Texts>(en);
effect(() => {
  const name = language.value;
  const load = name === "en" ? undefined : FILES[fileOf(name)];
  if (load === undefined) return void (texts.value = en);
  Promise.all([load(), SAID[`./said/${name}.json`]?.()]).then(
    ([loaded, said]) => {
      if (language.peek() === name) texts.value = { ...said, ...loaded };
    },
    () => {},
  );
});

/** A sentence, with what stands in braces replaced. */
export function t(key: Key, values: Record<string, string | number> = {}): string {
  return filled(texts.value[key] ?? en[key] ?? key, values);
}

export const filled = (text: string, values: Record<string, string | number>): string =>
  text.replace(/\{(\w+)\}/g, (all, name: string) => String(values[name] ?? all));

/** What the language has under this key, else what the station says: English it says by itself. */
export const told = (key: string, or: string): string => (texts.value as Record<string, string>)[key] ?? or;

/** A sentence of the station as data: its English template and the values in it. */
export interface Sentence {
  template?: string;
  values?: readonly Value[];
}
interface Value extends Sentence {
  name: string;
  text?: string;
  option?: string;
}

/** What an option is called; the panels that ask for options know more of their names. */
export const names = { option: (name: string): string => told(`setup.${name}`, name) };

const words = ({ template = "", values = [] }: Sentence): string =>
  filled(
    told(template, template),
    Object.fromEntries(
      values.map((value) => [
        value.name,
        value.text ?? (value.option === undefined ? words(value) : `“${names.option(value.option)}”`),
      ]),
    ),
  );

/** A sentence of the station in the language of the page, with options by the names that they have there. */
export const sentence = (of: Sentence): string => words(of).replace(/^[a-z](?=[a-z])/, (first) => first.toUpperCase());
