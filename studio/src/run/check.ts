// What a program would do: asked of the station, shown in the picture before anything moves.
import { computed, effect, signal } from "@preact/signals";
import { complain } from "../actions";
import { RpcError } from "../client";
import { call, shown } from "../session";
import * as store from "../store";
import { type Lines, show } from "../view/layers";
import { busy } from "./jobs";
import { type Entry, programs } from "./programs";

export interface Option {
  name: string;
  kind: "choice" | "number" | "point" | "switch";
  unit: string;
  choices: string[];
  with: string | null;
  about: string;
}
export interface Complaint {
  step: number;
  line?: number;
  column?: number;
  name?: string;
  message: string;
}
export interface Report {
  ok: boolean;
  seconds: number | null;
  steps: number | null;
  drawn_mm: number;
  travel_mm: number;
  bounds?: Record<"x" | "y" | "z", [number, number]>;
  refused: number;
  complaints: Complaint[];
  notes?: Array<{ code: string; text: string }>;
  preview?: { strokes: Array<{ points: number[][]; height: number; reachable: boolean }>; travels: number[][][] };
}

const CHECK_FAILED = -32004;
/** Larger files are checked when they are asked for: it takes a while. */
const AT_ONCE = 1024 * 1024;
const PAUSE = 400;

export const selected = signal<string | null>(null);
export const entry = computed<Entry | null>(() => programs.value.find((program) => program.name === selected.value) ?? null);
export const options = signal<Option[]>([]);
export const values = signal<Record<string, string>>({});
export const report = signal<Report | null>(null);
/** What keeps it from being checked at all: one sentence. */
export const problem = signal<string | null>(null);
export const isChecking = signal(false);
export const isShown = signal(false);
let asked = 0;
/** What the newest check comes to. */
let newest: Promise<boolean> = Promise.resolve(false);

/** Whether an option counts, as the others are set. */
export const counts = (option: Option): boolean => option.with === null || values.value[option.with] === "true";

/** What is set, as the station takes it; nothing where nothing is. */
export const setup = computed<Record<string, unknown> | undefined>(() => {
  const set: Record<string, unknown> = {};
  for (const option of options.value.filter(counts)) {
    const text = (values.value[option.name] ?? "").trim().replaceAll(",", " ");
    const numbers = text === "" ? [] : text.split(/\s+/).map(Number);
    if (option.kind === "choice") set[option.name] = text || option.choices[0];
    else if (option.kind === "switch" && text === "true") set[option.name] = true;
    else if (option.kind === "number" && numbers.length > 0) set[option.name] = numbers[0];
    else if (option.kind === "point" && numbers.length > 0) set[option.name] = numbers;
  }
  return Object.keys(set).length > 0 ? set : undefined;
});

export const source = () => ({ program: selected.value ?? "", ...(setup.value ? { setup: setup.value } : {}) });

export async function select(name: string | null): Promise<void> {
  selected.value = name;
  forget();
  options.value = [];
  values.value = {};
  const format = entry.value?.format;
  if (name === null || !format) return;
  try {
    const found = await call("program.options", { format });
    if (selected.value === name) options.value = found.options as Option[];
  } catch (error) {
    complain(error);
  }
}

function forget(): void {
  asked++;
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
  if (selected.value === null) return false;
  const mine = ++asked;
  problem.value = null;
  isChecking.value = true;
  try {
    const found = (await call("job.check", { ...shown(), ...source(), preview: true })) as unknown as Report;
    if (mine !== asked) return newest;
    report.value = found;
    draw(found);
    return found.ok;
  } catch (error) {
    if (mine !== asked) return newest;
    forget();
    refuse(error);
    return false;
  } finally {
    if (mine === asked) isChecking.value = false;
  }
}

/** A refusal of a check or a start: its report, or its sentence. */
export function refuse(error: unknown): void {
  const found = error instanceof RpcError && error.code === CHECK_FAILED ? (error.data["report"] as Report | undefined) : undefined;
  if (found !== undefined) report.value = found;
  else problem.value = error instanceof Error ? error.message : String(error);
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

/** Checks by itself what is small, as long as the panel is open and the arm is at no job. */
export function checkAlong(): () => void {
  let due: ReturnType<typeof setTimeout> | undefined;
  const end = effect(() => {
    const found = entry.value;
    const isUp = store.isUp.value;
    void setup.value;
    clearTimeout(due);
    if (found === null || found.format === null) return;
    if (found.bytes > AT_ONCE) forget();
    else if (isUp && !busy.peek()) due = setTimeout(() => void check(), PAUSE);
  });
  return () => {
    clearTimeout(due);
    end();
    show("planned", []);
    isShown.value = false;
  };
}
