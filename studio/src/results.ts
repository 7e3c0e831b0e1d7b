// Pictures drawn by virtual arms, stored in the browser for the teacher's view, so that a reload
// keeps them.
import { log } from "./log";
import type { Picture } from "./site";
import { filterStored, isListOf, isMap, isObjectOf, isText } from "./storage";
import { toReader } from "./view/flat";

const STORE_NAME = "pictures";
/** Largest number of pictures, and of characters in all, that are kept. */
const MAX_PICTURES = 120;
const MAX_CHARACTERS = 20e6;

const isPicture = isObjectOf({
  name: isText,
  at: (value) => value instanceof Date && !Number.isNaN(value.getTime()),
  svg: isText,
  strokes: isListOf(isMap),
});

let database: Promise<IDBDatabase> | null = null;

function promiseOf<T>(request: IDBRequest<T>): Promise<T> {
  return new Promise((done, failed) => {
    request.onsuccess = () => done(request.result);
    request.onerror = () => failed(request.error);
  });
}

function openStore(mode: IDBTransactionMode): Promise<IDBObjectStore> {
  database ??= new Promise((done, failed) => {
    const asked = indexedDB.open("magician.results", 1);
    asked.onupgradeneeded = () => asked.result.createObjectStore(STORE_NAME, { keyPath: "name" });
    promiseOf(asked).then(done, failed);
  });
  return database.then((base) => base.transaction(STORE_NAME, mode).objectStore(STORE_NAME));
}

/** Newest pictures that fit. */
export function newest(pictures: readonly Picture[]): Picture[] {
  let signs = 0;
  return pictures.slice(0, MAX_PICTURES).filter(({ svg }, nth) => (signs += svg.length) <= MAX_CHARACTERS || nth === 0);
}

/** Stored pictures; empty in a browser without storage. */
export async function storedPictures(): Promise<Picture[]> {
  try {
    const all = (await promiseOf((await openStore("readonly")).getAll())) as unknown[];
    return filterStored<Picture>(STORE_NAME, all, isPicture).sort(
      (one, other) => other.at.getTime() - one.at.getTime(),
    );
  } catch {
    return [];
  }
}

/** Stores a picture, and deletes those with these names. */
export async function updatePictures(put: Picture | null, drop: readonly string[]): Promise<void> {
  try {
    const base = await openStore("readwrite");
    if (put !== null) base.put(put);
    for (const name of drop) base.delete(name);
    await new Promise((done, failed) => {
      base.transaction.oncomplete = done;
      base.transaction.onabort = () => failed(base.transaction.error);
    });
  } catch (error) {
    // Without storage they last until the page is closed.
    log(String(error));
  }
}

const escaped = (text: string) => text.replace(/[&<>"]/g, (sign) => `&#${sign.charCodeAt(0)};`);

/** All pictures as one page for printing. */
export function printablePage(title: string, pictures: readonly Picture[]): string {
  const figures = pictures.map(
    ({ name, at, svg }) =>
      `<figure>${toReader(svg)}<figcaption>${escaped(name)}<br>${escaped(at.toLocaleString())}</figcaption></figure>`,
  );
  const style =
    "body{font:14px sans-serif;display:flex;flex-wrap:wrap;gap:16px}figure{margin:0;break-inside:avoid;width:280px}svg{width:100%;height:220px;border:1px solid #ccc}";
  return `<!doctype html><meta charset="utf-8"><title>${escaped(title)}</title><style>${style}</style><h1 style="width:100%">${escaped(title)}</h1>${figures.join("")}`;
}
