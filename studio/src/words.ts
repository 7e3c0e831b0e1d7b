// Sentences of a panel that come with it and not with the page's frame.
import { filled } from "./i18n";
import { language } from "./settings";

type Values = Record<string, string | number>;

/** Says the sentences of a panel in the language that is chosen. Both languages have the same keys, or this does not compile. */
export function sentencesOf<Word extends string>(texts: {
  en: Record<Word, string>;
  zh: Record<NoInfer<Word>, string>;
}) {
  return (key: Word, values: Values = {}): string =>
    filled((language.value === "zh" ? texts.zh : texts.en)[key] ?? key, values);
}
