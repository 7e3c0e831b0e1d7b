// Storage of the user's work in the browser, as JSON. A value is read back only if it has the expected
// shape; a damaged value, or one of another version of the page, is moved aside under another name,
// and the page starts empty.
import { t, told } from "./i18n";
import { log } from "./log";
import { remember, remembered, type Storage } from "./settings";
import * as store from "./store";

/** Suffix of a value moved aside. A later damaged value replaces it. */
const ASIDE = ".damaged";

const isIt = (takes: (value: unknown) => boolean, value: unknown): boolean => {
  try {
    return takes(value);
  } catch {
    return false;
  }
};

/** Moves a damaged value aside and reports it. */
function setAside(of: Storage, name: string, text: string): void {
  remember(of, name + ASIDE, text);
  remember(of, name, null);
  const said = t("kept.damaged", { name: told(`nav.${name}`, name) });
  log(said);
  store.say(said, true);
}

/** Returns the value stored under a name if `takes` accepts it, else null. */
export function kept<T>(of: Storage, name: string, takes: (value: unknown) => boolean): T | null {
  const text = remembered(of, name);
  if (text === null) return null;
  let value: unknown;
  try {
    value = JSON.parse(text);
  } catch {
    value = undefined;
  }
  if (isIt(takes, value)) return value as T;
  setAside(of, name, text);
  return null;
}

export const keep = (of: Storage, name: string, value: unknown): void =>
  remember(of, name, value === null ? null : JSON.stringify(value));

/** Returns the elements of a list that `takes` accepts. */
export function only<T>(name: string, all: readonly unknown[], takes: (value: unknown) => boolean): T[] {
  const good = all.filter((one) => isIt(takes, one));
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
export const isOr =
  (...shapes: Shape[]): Shape =>
  (value) =>
    shapes.some((shape) => shape(value));
export const isNull: Shape = (value) => value === null;
export const isUnset: Shape = (value) => value === undefined;
/** Accepts an object with at least these members. */
export const has =
  (members: Record<string, Shape>): Shape =>
  (value) =>
    isMap(value) && Object.entries(members).every(([name, shape]) => shape((value as Record<string, unknown>)[name]));

/** Delay between a change and the write, ms: a drag changes the document with every move. */
const RESTS = 250;

/**
 * A document of the user, such as the rows of a program, that survives a reload and a closed browser.
 * Each tab has its own; a new tab starts with the last one left by any tab. Documents for which
 * `isEmpty` is true are not left.
 */
export class Document<T> {
  private due: ReturnType<typeof setTimeout> | undefined;
  private now: T | null = null;

  constructor(
    private readonly name: string,
    private readonly takes: (value: unknown) => boolean,
    private readonly isEmpty: (value: T) => boolean,
  ) {
    addEventListener("pagehide", () => {
      this.flush();
      if (this.now === null) return;
      // Later values of other tabs are not what the user of this tab saw last.
      keep("sessionStorage", this.name, this.now);
      if (!this.isEmpty(this.now)) keep("localStorage", this.name, this.now);
    });
  }

  read(): T | null {
    return kept<T>("sessionStorage", this.name, this.takes) ?? kept<T>("localStorage", this.name, this.takes);
  }

  write(value: T): void {
    const isFirst = this.now === null;
    this.now = value;
    // A value just read need not be written.
    if (isFirst) return;
    clearTimeout(this.due);
    this.due = setTimeout(() => this.flush(), RESTS);
  }

  private flush(): void {
    if (this.due === undefined) return;
    clearTimeout(this.due);
    this.due = undefined;
    for (const of of ["localStorage", "sessionStorage"] as const) keep(of, this.name, this.now);
  }
}
