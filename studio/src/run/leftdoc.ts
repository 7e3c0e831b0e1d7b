// The objects of a workshop over a reload of the page: what lies on the sheet, and what is set of the job.
import { Document, has, isListOf, isMapOf, isNull, isNumber, isOr, isText, isUnset } from "../shelf";
import type { Doc } from "./items";
import type { Values } from "./shop";

export interface Left {
  doc: Doc;
  common: Values;
}

const isSomeText = isOr(isUnset, isText);
const isPlace = has({
  at: isListOf(isNumber, 2),
  scale: (value) => isNumber(value) && (value as number) > 0,
  turn: isNumber,
});
const isValues = isMapOf(isText);
const isItem = has({
  id: isNumber,
  source: has({ program: isSomeText, text: isSomeText, format: isSomeText }),
  format: isText,
  name: isText,
  shape: isSomeText,
  color: isOr(isNull, isText),
  values: isValues,
  place: isOr(isNull, isPlace),
});
const isLeft = has({ doc: has({ items: isListOf(isItem), chosen: isOr(isNull, isNumber) }), common: isValues });

/** Of a workshop by its name. */
export const leftOf = (name: string): Document<Left> => new Document(name, isLeft, ({ doc }) => doc.items.length === 0);
