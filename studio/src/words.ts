// Sentences of a panel, loaded with it instead of with the page's frame.
import { interpolate } from "./i18n";
import { language } from "./settings";

type Values = Record<string, string | number>;

/** Texts of a panel in the chosen language. A key missing in one language is a compile error. */
export function sentencesOf<Word extends string>(texts: {
  en: Record<Word, string>;
  zh: Record<NoInfer<Word>, string>;
}) {
  return (key: Word, values: Values = {}): string =>
    interpolate((language.value === "zh" ? texts.zh : texts.en)[key] ?? key, values);
}
