// Sentences of the job's strip.
import { sentencesOf } from "../words";
import texts from "./strip.json";

export const w = sentencesOf(texts);
