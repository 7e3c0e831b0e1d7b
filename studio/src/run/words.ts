// Names of options, their choices and groups. Those of rarely used options are loaded with the
// panels of programs.
import type { Remedy } from "../actions";
import type { Note, Option } from "../api";
import { filled, names, sentence, t, told } from "../i18n";
import texts from "../panels/setup.words.json";
import { language } from "../settings";

const WORDS: Record<string, Record<string, string>> = texts;
export const named = (key: string, or: string): string =>
  told(`setup.${key}`, WORDS[language.value]?.[key] ?? WORDS.en?.[key] ?? or);
export const labelOf = ({ name, about }: Option): string => named(name, about);

names.option = (name) => named(name, name);

/** Name of an option's choice. */
export const choiceOf = (name: string, choice: string): string => named(`${name}.${choice}`, choice);

/** Text of a remedy, with the page's name of the option; empty if the page has no such option. */
function act({ action, option, without, value }: Remedy): string {
  if (action !== undefined) return told(`remedy.${action}`, "");
  const name = option ?? without ?? "";
  const label = named(name, "");
  if (label === "") return "";
  if (without !== undefined) return t("remedy.without", { name: label });
  const key = value === true ? "said.on" : value === false ? "said.off" : "said.set";
  if (value === undefined) return `“${label}”`;
  const given = Array.isArray(value) ? value.join(", ") : choiceOf(name, String(value));
  return filled(named(key, ""), { name: label, value: given });
}

/** Note with its advice, for places without buttons. */
export function noteOf(note: Note): string {
  const colon = named("said.colon", "");
  const remedies = ((note.remedies ?? []) as Remedy[]).flatMap((remedy) => {
    const done = act(remedy);
    if (done === "") return [];
    return remedy.effect ? `${done}${colon}${told(remedy.effect, remedy.effect)}` : done;
  });
  const advice = [...(note.help ? [told(note.help.template, note.help.template)] : []), ...remedies];
  if (advice.length === 0) return sentence(note);
  return filled(named("said.advice", ""), { what: sentence(note), advice: advice.join(named("said.and", "")) });
}

/** Note for a place with buttons for its remedies. */
export const plainNoteOf = (note: Note): string => noteOf({ ...note, remedies: [] });
