// Sentences of the class pages, loaded with them instead of with the page's frame.
import { sentencesOf } from "../../words";
import texts from "./words.json";

export type Word = keyof typeof texts.en;

export const w = sentencesOf(texts);

/** True if there is a sentence for this key. */
export const isWord = (key: string): key is Word => key in texts.en;
