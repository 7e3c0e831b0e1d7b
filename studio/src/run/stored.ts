// The objects of a workshop over a reload of the page: what lies on the sheet, and what is set of the job.
import { Document, isEither, isListOf, isMapOf, isNull, isNumber, isObjectOf, isText, isUnset } from "../storage";
import type { Doc } from "./items";
import type { Values } from "./workshop";

export interface StoredWorkshop {
  doc: Doc;
  common: Values;
}

const isOptionalText = isEither(isUnset, isText);
const isPlace = isObjectOf({
  at: isListOf(isNumber, 2),
  scale: (value) => isNumber(value) && (value as number) > 0,
  turn: isNumber,
});
const isValues = isMapOf(isText);
const isItem = isObjectOf({
  id: isNumber,
  source: isObjectOf({ program: isOptionalText, text: isOptionalText, format: isOptionalText }),
  format: isText,
  name: isText,
  shape: isOptionalText,
  color: isEither(isNull, isText),
  values: isValues,
  place: isEither(isNull, isPlace),
});
const isStoredWorkshop = isObjectOf({
  doc: isObjectOf({ items: isListOf(isItem), chosen: isEither(isNull, isNumber) }),
  common: isValues,
});

/** Of a workshop by its name. */
export const storedWorkshop = (name: string): Document<StoredWorkshop> =>
  new Document(name, isStoredWorkshop, ({ doc }) => doc.items.length === 0);
