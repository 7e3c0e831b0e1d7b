// Sentences of the work surface and the paper.
import { sentencesOf } from "../words";
import texts from "./surface.json";

export const w = sentencesOf(texts);
