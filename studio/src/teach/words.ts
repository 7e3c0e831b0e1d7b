// The sentences of teaching.
import { wordsOf } from "../words";
import texts from "./words.json";

export type Word = keyof typeof texts.en;

export const w = wordsOf(texts);
