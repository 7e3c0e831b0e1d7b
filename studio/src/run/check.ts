// What a program would do: asked of the station, shown in the picture before anything moves.
import { computed, effect, signal } from "@preact/signals";
import { complain, type Problem, problemOf, tried } from "../actions";
import type { Option, Report } from "../api";
import { type Params, RpcError } from "../client";
import { call, shown } from "../session";
import * as store from "../store";
import { type Lines, show } from "../view/layers";
import * as jobs from "./jobs";
import { type Entry, nameOf, programs, put } from "./programs";
import { height } from "./surface";

/** What is checked and run: a program of the library, or what a person has typed. */
export type Source = Pick<Params<"job.start">, "program" | "text" | "format">;

const CHECK_FAILED = -32004;
/** Larger files are checked when they are asked for: it takes a while. */
const AT_ONCE = 1024 * 1024;
const PAUSE = 400;
/** A range as people write it. */
const RANGE = /^([\d.]+)\s*(?:-|–|to|到)\s*([\d.]+)$/;

export const chosen = signal<Source | null>(null);
export const selected = computed(() => chosen.value?.program ?? null);
export const entry = computed<Entry | null>(
  () => programs.value.find((program) => program.name === selected.value) ?? null,
);
export const options = signal<Option[]>([]);
export const values = signal<Record<string, string>>({});
export const report = signal<Report | null>(null);
/** What keeps it from being checked at all. */
export const problem = signal<Problem | null>(null);
export const isChecking = signal(false);
export const isShown = signal(false);
let checks = 0;
/** What the newest check comes to. */
let newest: Promise<boolean> = Promise.resolve(false);

/** What the open route says itself, whatever a person has set. */
export const fixed = signal<Record<string, unknown>>({});
/** What an option comes to; nothing where the station decides. */
// biome-ignore lint/suspicious/noShadowRestrictedNames: nobody calls the one of objects
export const valueOf = (name: string): string => {
  // It is not asked: the tool says it.
  if (name === "work" && !(name in fixed.value)) return valueOf("tool") === "laser" ? "engrave" : "draw";
  const option = options.value.find((one) => one.name === name);
  return String(fixed.value[name] ?? (values.value[name] || (option?.default ?? "")));
};
export const setValue = (name: string, to: string): void => void (values.value = { ...values.value, [name]: to });

/** Whether an option counts, as the others are set: what it counts with has to count itself. */
function counts({ with: name, when }: Option): boolean {
  if (name === null) return true;
  const other = options.value.find((one) => one.name === name);
  if (other !== undefined && !counts(other)) return false;
  return when.length === 0 ? valueOf(name) === "true" : when.includes(valueOf(name));
}
/** What a person is asked: what counts, and the open route does not say itself. */
export const asked = computed(() => options.value.filter((option) => !(option.name in fixed.value) && counts(option)));

/** What is set, as the station takes it; nothing where nothing is. */
export const setup = computed<Record<string, unknown> | undefined>(() => {
  const set: Record<string, unknown> = {};
  for (const { name, kind, usual, choices } of asked.value) {
    const text = (values.value[name] ?? "").trim();
    const numbers = text.replaceAll(",", " ").split(/\s+/).map(Number);
    if (kind === "choice" && usual) set[name] = text || choices[0];
    else if (text === "") continue;
    else if (kind === "switch") set[name] = text === "true";
    else if (kind === "number" || kind === "integer") set[name] = numbers[0];
    else if (kind === "point" || kind === "place" || kind === "area") set[name] = numbers;
    else if (kind === "list") set[name] = text.split("\n");
    else if (kind !== "pens") set[name] = name === "power" ? text.replace(RANGE, "$1..$2") : text;
  }
  Object.assign(set, fixed.value);
  return Object.keys(set).length > 0 ? set : undefined;
});

export const source = () => ({ ...chosen.value, ...(setup.value ? { setup: setup.value } : {}) });

export const select = (name: string | null) => choose(name === null ? null : { program: name });

/** Takes something else; another text with the same options. */
export async function choose(source: Source | null): Promise<void> {
  const isSame =
    source?.text !== undefined && chosen.value?.text !== undefined && source.format === chosen.value.format;
  chosen.value = source;
  if (isSame) return;
  forget();
  options.value = [];
  // How somebody draws holds for the next drawing too; what its parts are, and which of them, does not.
  const { only: _, parts: _parts, no_pause: _pause, ...kept } = values.value;
  values.value = Object.keys(fixed.value).length === 0 ? {} : kept;
  const format = source?.format ?? entry.value?.format;
  if (!format) return;
  try {
    const found = await call("program.options", { format, all: true });
    if ((chosen.value?.format ?? entry.value?.format) === format) options.value = found.options;
  } catch (error) {
    complain(error);
  }
}

/** Puts files into the library; the last one is taken. */
export async function openFiles(files: Iterable<File>): Promise<void> {
  for (const file of files) {
    await tried(async () => {
      const name = await put(nameOf(file.name), file);
      if (name !== null) await select(name);
    });
  }
}

function forget(): void {
  checks++;
  newest = Promise.resolve(false);
  report.value = null;
  problem.value = null;
  isChecking.value = false;
  show("planned", []);
  isShown.value = false;
}

/** Checks the program, and shows what it would do; whether the arm can do it. One that a newer check has overtaken answers as that does. */
export const check = (): Promise<boolean> => (newest = checked());

async function checked(): Promise<boolean> {
  if (chosen.value === null) return false;
  const mine = ++checks;
  problem.value = null;
  isChecking.value = true;
  try {
    const found = await call("job.check", { ...shown(), ...source(), preview: true });
    if (mine !== checks) return newest;
    report.value = found;
    draw(found);
    return found.ok;
  } catch (error) {
    if (mine !== checks) return newest;
    forget();
    refuse(error);
    return false;
  } finally {
    if (mine === checks) isChecking.value = false;
  }
}

/** A refusal of a check or a start: its report, or its sentence. */
export function refuse(error: unknown): void {
  const found =
    error instanceof RpcError && error.code === CHECK_FAILED ? (error.data.report as Report | undefined) : undefined;
  if (found !== undefined) report.value = found;
  else problem.value = problemOf(error);
}

export function draw(found: Report | null): void {
  const { strokes, travels } = found?.preview ?? { strokes: [], travels: [] };
  const lines: Lines[] = strokes.map(({ points, height, reachable }) => ({
    points: points.map(([x = 0, y = 0]) => [x, y, height]),
    color: reachable ? "--planned" : "--stop",
  }));
  const ways = travels.map((points): Lines => ({ points, color: "--muted", opacity: 0.4 }));
  show("planned", [...lines, ...ways]);
  isShown.value = lines.length + ways.length > 0;
}

/** Starts what is chosen, with more of the setup than is set; `about` tells the person who is asked what it does. */
export const start = (title: string, about: string, more: Pick<jobs.Order, "loops" | "setup"> = {}) =>
  tried(async () => {
    const wanted = source();
    // What is known to be impossible is looked at once more: the arm may stand elsewhere now.
    if (report.value?.ok !== true && !(await check())) return;
    // Nobody has pressed for what was chosen meanwhile.
    if (JSON.stringify(source()) !== JSON.stringify(wanted)) return;
    // Without any a program is run as it is.
    const setup = wanted.setup || more.setup ? { setup: { ...wanted.setup, ...more.setup } } : {};
    try {
      await jobs.start({ ...wanted, ...more, ...setup }, title, about);
    } catch (error) {
      refuse(error);
    }
  });

/** Checks by itself what is no larger than this, as long as the panel is open and the arm is at no job. */
export function checkAlong(most = AT_ONCE): () => void {
  let due: ReturnType<typeof setTimeout> | undefined;
  const end = effect(() => {
    const found = entry.value;
    const isIdle = store.isUp.value && !jobs.busy.value;
    void setup.value;
    void height.value;
    void store.isHomed.value;
    clearTimeout(due);
    if (chosen.value === null || found?.format === null) return;
    if (found !== null && found.bytes > most) forget();
    else if (isIdle) due = setTimeout(() => void check(), PAUSE);
  });
  return () => {
    clearTimeout(due);
    end();
    show("planned", []);
    isShown.value = false;
  };
}
