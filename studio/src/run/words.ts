// Names of options, their choices and groups. Those of rarely used options are loaded with the
// panels of programs.
import type { Remedy } from "../actions";
import type { Note, Option } from "../api";
import { interpolate, names, sentence, t, translated } from "../i18n";
import texts from "../panels/setup.words.json";
import { language } from "../settings";

const OPTION_TEXTS: Record<string, Record<string, string>> = texts;
export const optionText = (key: string, or: string): string =>
  translated(`setup.${key}`, OPTION_TEXTS[language.value]?.[key] ?? OPTION_TEXTS.en?.[key] ?? or);
export const labelOf = ({ name, about }: Option): string => optionText(name, about);

names.option = (name) => optionText(name, name);

/** Name of an option's choice. */
export const choiceOf = (name: string, choice: string): string => optionText(`${name}.${choice}`, choice);

/** Text of a remedy, with the page's name of the option; empty if the page has no such option. */
function remedyText({ action, option, without, value }: Remedy): string {
  if (action !== undefined) return translated(`remedy.${action}`, "");
  const name = option ?? without ?? "";
  const label = optionText(name, "");
  if (label === "") return "";
  if (without !== undefined) return t("remedy.without", { name: label });
  const key = value === true ? "said.on" : value === false ? "said.off" : "said.set";
  if (value === undefined) return `“${label}”`;
  const given = Array.isArray(value) ? value.join(", ") : choiceOf(name, String(value));
  return interpolate(optionText(key, ""), { name: label, value: given });
}

/** Note with its advice, for places without buttons. */
export function noteText(note: Note): string {
  const colon = optionText("said.colon", "");
  const remedies = ((note.remedies ?? []) as Remedy[]).flatMap((remedy) => {
    const done = remedyText(remedy);
    if (done === "") return [];
    return remedy.effect ? `${done}${colon}${translated(remedy.effect, remedy.effect)}` : done;
  });
  const advice = [...(note.help ? [translated(note.help.template, note.help.template)] : []), ...remedies];
  if (advice.length === 0) return sentence(note);
  return interpolate(optionText("said.advice", ""), {
    what: sentence(note),
    advice: advice.join(optionText("said.and", "")),
  });
}

/** Note for a place with buttons for its remedies. */
export const plainNoteText = (note: Note): string => noteText({ ...note, remedies: [] });
