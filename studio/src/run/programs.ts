// Library of programs: upload, download, and single lines. No file is read as a whole on the page's
// main thread.
import { signal } from "@preact/signals";
import { type Result, RpcError } from "../client";
import { t } from "../i18n";
import { call, fileEndpoint, localFile } from "../session";
import * as store from "../store";

export type Entry = Result<"program.list">["programs"][number];

/** Largest program in a message or an answer, bytes. */
export const MAX_MESSAGE_BYTES = 700 * 1024;

export const programs = signal<Entry[]>([]);
export const isLoading = signal(false);

export async function readLibrary(): Promise<void> {
  const { programs: all } = await call("program.list", {});
  programs.value = all.toSorted((one, two) => two.modified - one.modified);
}

/** The longest name that the library takes. */
const MAX_NAME_LENGTH = 80;

/** Four signs that another text has others of. */
function shortHash(text: string): string {
  let sum = 0;
  for (const sign of text) sum = (Math.imul(sum, 31) + (sign.codePointAt(0) ?? 0)) >>> 0;
  return (sum % 36 ** 4).toString(36).padStart(4, "0");
}

/** A name with more behind its stem, no longer than the library takes. */
function withSuffix(name: string, more: string): string {
  const dot = name.lastIndexOf(".");
  const [stem, ending] = dot > 0 ? [name.slice(0, dot), name.slice(dot).slice(0, 20)] : [name, ""];
  return (stem.slice(0, MAX_NAME_LENGTH - ending.length - more.length).trim() || "program") + more + ending;
}

/** A name that the library takes, as near as may be to what the file is called. Names that differ in letters that it does not take
    still differ. */
export function libraryName(file: string): string {
  const latin = file.normalize("NFKD").replace(/\p{Mark}+/gu, "");
  const isLost = /[\p{Letter}\p{Number}]/u.test(latin.replace(/[A-Za-z0-9]+/g, ""));
  const plain = latin
    .replace(/[^A-Za-z0-9._ -]+/g, "_")
    .replace(/^[. ]+/, "")
    .replace(isLost ? /^_(?=\.|$)/ : /$^/, "program")
    .trim();
  return withSuffix(plain, isLost ? `-${shortHash(file.normalize("NFC"))}` : "");
}

/** Returns this name, numbered if the library has it already. */
export async function unusedName(name: string): Promise<string> {
  await readLibrary();
  const taken = new Set(programs.value.map((program) => program.name));
  let made = name;
  for (let number = 2; taken.has(made); number++) made = withSuffix(name, ` ${number}`);
  return made;
}

/** Stores a file that comes with the page, next to a program of the user with the same name. Returns the name. */
export async function storeUnused(name: string, content: Blob): Promise<string> {
  await readLibrary();
  const there = programs.value.find((program) => program.name === name);
  if (there !== undefined && there.bytes === content.size) {
    const [one, other] = await Promise.all([
      fetchProgram(there).then((blob) => blob.arrayBuffer()),
      content.arrayBuffer(),
    ]);
    if (base64(one) === base64(other)) return name;
  }
  const free = await unusedName(name);
  await storeProgram(free, content, true);
  return free;
}

/** True if the name is free in the library, or the user agrees to replace the program. */
export async function confirmReplace(name: string): Promise<boolean> {
  // The list of a new page is still empty, and other pages save programs too.
  await readLibrary();
  if (!programs.value.some((program) => program.name === name)) return true;
  return store.ask(t("replace.title", { name }), t("programs.replace.text"), t("replace"));
}

/**
 * Saves a file in the library. Returns its name, or null if the user does not want to replace a
 * program.
 */
export async function storeProgram(name: string, content: Blob, replaces = false): Promise<string | null> {
  if (!replaces && !(await confirmReplace(name))) return null;
  isLoading.value = true;
  try {
    const own = localFile();
    if (content.size <= MAX_MESSAGE_BYTES)
      await call("program.put", { name, data: base64(await content.arrayBuffer()) });
    else if (own !== null) await own(name, await content.arrayBuffer());
    else if (!(await uploadProgram(name, content))) throw new RpcError(0, t("programs.large", { name }));
    await readLibrary();
  } finally {
    isLoading.value = false;
  }
  return name;
}

/** Uploads a file by HTTP, so that the browser reads it. */
async function uploadProgram(name: string, body: Blob): Promise<boolean> {
  const to = fileEndpoint();
  if (to === null) return false;
  let answer: Response;
  try {
    answer = await fetch(to.url + encodeURIComponent(name), { method: "PUT", headers: to.headers, body });
  } catch {
    return false;
  }
  if (!answer.ok) throw new RpcError(answer.status, (await answer.text()) || answer.statusText);
  return true;
}

export function base64(bytes: ArrayBuffer): string {
  let text = "";
  const all = new Uint8Array(bytes);
  for (let at = 0; at < all.length; at += 0x8000) text += String.fromCharCode(...all.subarray(at, at + 0x8000));
  return btoa(text);
}

/** Content of a program. */
export async function fetchProgram(entry: Entry): Promise<Blob> {
  if (entry.bytes > MAX_MESSAGE_BYTES) {
    const own = localFile();
    if (own !== null) return new Blob([await own(entry.name)]);
    const from = fileEndpoint();
    if (from === null) throw new RpcError(0, t("programs.large", { name: entry.name }));
    const answer = await fetch(from.url + encodeURIComponent(entry.name), { headers: from.headers });
    if (!answer.ok) throw new RpcError(answer.status, (await answer.text()) || answer.statusText);
    return answer.blob();
  }
  const { data } = await call("program.get", { name: entry.name });
  const text = atob(data);
  return new Blob([Uint8Array.from(text, (sign) => sign.charCodeAt(0))]);
}

export async function deleteProgram(name: string): Promise<void> {
  if (!(await store.ask(t("programs.delete.title", { name }), t("programs.delete.text"), t("programs.delete")))) return;
  await call("program.delete", { name });
  await readLibrary();
}

export interface Line {
  number: number;
  text: string;
}

/** Number of lines shown before and after a line, and the longest part of each, characters. */
const CONTEXT_LINES = 2;
const MAX_LINE_LENGTH = 200;

/** Line with its neighbours. The file is read in pieces, and only as far as needed. */
export async function linesAt(content: Blob, line: number): Promise<Line[]> {
  const found: Line[] = [];
  const reader = content.stream().pipeThrough(new TextDecoderStream()).getReader();
  for (let [number, rest, isOver] = [1, "", false]; !isOver; ) {
    const { value = "", done } = await reader.read();
    const lines = (rest + value).split("\n");
    rest = done ? "" : (lines.pop() ?? "");
    for (const text of lines) {
      if (number >= line - CONTEXT_LINES && number <= line + CONTEXT_LINES)
        found.push({ number, text: text.replace(/\r$/, "").slice(0, MAX_LINE_LENGTH) });
      number++;
    }
    isOver = done || number > line + CONTEXT_LINES;
  }
  void reader.cancel();
  return found;
}
