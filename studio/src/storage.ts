// Storage of the user's work in the browser, as JSON. A value is read back only if it has the expected
// shape; a damaged value, or one of another version of the page, is moved aside under another name,
// and the page starts empty.
import { t, translated } from "./i18n";
import { log } from "./log";
import { readValue, type Storage, writeValue } from "./settings";
import * as store from "./store";

/** Suffix of a value moved aside. A later damaged value replaces it. */
const DAMAGED_SUFFIX = ".damaged";

const isAccepted = (takes: (value: unknown) => boolean, value: unknown): boolean => {
  try {
    return takes(value);
  } catch {
    return false;
  }
};

/** Moves a damaged value aside and reports it. */
function setAside(of: Storage, name: string, text: string): void {
  writeValue(of, name + DAMAGED_SUFFIX, text);
  writeValue(of, name, null);
  const said = t("kept.damaged", { name: translated(`nav.${name}`, name) });
  log(said);
  store.notify(said, true);
}

/** Returns the value stored under a name if `takes` accepts it, else null. */
export function readStored<T>(of: Storage, name: string, takes: (value: unknown) => boolean): T | null {
  const text = readValue(of, name);
  if (text === null) return null;
  let value: unknown;
  try {
    value = JSON.parse(text);
  } catch {
    value = undefined;
  }
  if (isAccepted(takes, value)) return value as T;
  setAside(of, name, text);
  return null;
}

export const writeStored = (of: Storage, name: string, value: unknown): void =>
  writeValue(of, name, value === null ? null : JSON.stringify(value));

/** Returns the elements of a list that `takes` accepts. */
export function filterStored<T>(name: string, all: readonly unknown[], takes: (value: unknown) => boolean): T[] {
  const good = all.filter((one) => isAccepted(takes, one));
  if (good.length < all.length) log(t("kept.damaged", { name }));
  return good as T[];
}

// Predicates for the shape of a value.
type Shape = (value: unknown) => boolean;
export const isText: Shape = (value) => typeof value === "string";
export const isNumber: Shape = (value) => typeof value === "number" && Number.isFinite(value);
export const isFlag: Shape = (value) => typeof value === "boolean";
export const isMap: Shape = (value) => typeof value === "object" && value !== null && !Array.isArray(value);
export const isListOf =
  (one: Shape, count?: number): Shape =>
  (value) =>
    Array.isArray(value) && (count === undefined || value.length === count) && value.every(one);
export const isMapOf =
  (one: Shape): Shape =>
  (value) =>
    isMap(value) && Object.values(value as object).every(one);
export const isEither =
  (...shapes: Shape[]): Shape =>
  (value) =>
    shapes.some((shape) => shape(value));
export const isNull: Shape = (value) => value === null;
export const isUnset: Shape = (value) => value === undefined;
/** Accepts an object with at least these members. */
export const isObjectOf =
  (members: Record<string, Shape>): Shape =>
  (value) =>
    isMap(value) && Object.entries(members).every(([name, shape]) => shape((value as Record<string, unknown>)[name]));

/** Delay between a change and the write, ms: a drag changes the document with every move. */
const WRITE_DELAY = 250;

/**
 * A document of the user, such as the rows of a program, that survives a reload and a closed browser.
 * Each tab has its own; a new tab starts with the last one left by any tab. Documents for which
 * `isEmpty` is true are not left.
 */
export class Document<T> {
  private timer: ReturnType<typeof setTimeout> | undefined;
  private unwritten: T | null = null;

  constructor(
    private readonly name: string,
    private readonly takes: (value: unknown) => boolean,
    private readonly isEmpty: (value: T) => boolean,
  ) {
    addEventListener("pagehide", () => {
      this.flush();
      if (this.unwritten === null) return;
      // Later values of other tabs are not what the user of this tab saw last.
      writeStored("sessionStorage", this.name, this.unwritten);
      if (!this.isEmpty(this.unwritten)) writeStored("localStorage", this.name, this.unwritten);
    });
  }

  read(): T | null {
    return (
      readStored<T>("sessionStorage", this.name, this.takes) ?? readStored<T>("localStorage", this.name, this.takes)
    );
  }

  write(value: T): void {
    const isFirst = this.unwritten === null;
    this.unwritten = value;
    // A value just read need not be written.
    if (isFirst) return;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.flush(), WRITE_DELAY);
  }

  private flush(): void {
    if (this.timer === undefined) return;
    clearTimeout(this.timer);
    this.timer = undefined;
    for (const of of ["localStorage", "sessionStorage"] as const) writeStored(of, this.name, this.unwritten);
  }
}
