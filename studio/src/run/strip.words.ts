// The sentences of the strip that tells of the job.
import { sentencesOf } from "../words";
import texts from "./strip.json";

export const w = sentencesOf(texts);
