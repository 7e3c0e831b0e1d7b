// Texts of the teach panel.
import { sentencesOf } from "../words";
import texts from "./words.json";

export type Word = keyof typeof texts.en;

export const w = sentencesOf(texts);
