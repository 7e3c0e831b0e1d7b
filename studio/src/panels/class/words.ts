// The sentences of the class's pages, which come with them and not with the page's frame.
import { filled } from "../../i18n";
import { language } from "../../settings";
import texts from "./words.json";

export type Word = keyof typeof texts.en;
/** Both have the same keys, or this does not compile. */
const LANGUAGES: Record<string, Record<Word, string>> = { en: texts.en, zh: texts.zh } satisfies Record<keyof typeof texts, Record<Word, string>>;

export const words = (): Record<string, string> => LANGUAGES[language.value] ?? texts.en;

export const w = (key: Word, values: Record<string, string | number> = {}): string => filled(words()[key] ?? key, values);
