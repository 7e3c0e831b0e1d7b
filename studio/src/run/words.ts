// What options, their choices and their groups are called. Those that are seldom set come with the panels of programs.
import type { Option } from "../api";
import { told } from "../i18n";
import texts from "../panels/setup.words.json";
import { language } from "../settings";

const WORDS: Record<string, Record<string, string>> = texts;
export const named = (key: string, or: string): string =>
  told(`setup.${key}`, WORDS[language.value]?.[key] ?? WORDS.en?.[key] ?? or);
export const labelOf = ({ name, about }: Option): string => named(name, about);
