// The sentences of the class's pages, which come with them and not with the page's frame.
import { sentencesOf } from "../../words";
import texts from "./words.json";

export type Word = keyof typeof texts.en;

export const w = sentencesOf(texts);

/** True if there is a sentence of this key. */
export const isWord = (key: string): key is Word => key in texts.en;
