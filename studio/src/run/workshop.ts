// State of a workshop: what to run with which options, and the result of its check. Each workshop
// has its own, so that they do not influence each other.
import { computed, effect, type ReadonlySignal, signal } from "@preact/signals";
import { attempt, type Problem, problemOf, reportError } from "../actions";
import type { Option, Report } from "../api";
import { type Params, RpcError } from "../client";
import { interpolate } from "../i18n";
import { parseNumbers } from "../numbers";
import { call, shownArm } from "../session";
import * as store from "../store";
import { type Lines, show } from "../view/layers";
import * as jobs from "./jobs";
import { type Entry, libraryName, programs, readLibrary, storeProgram } from "./programs";
import { knownSurface } from "./surface";
import { labelOf, optionText } from "./words";

/** Source of a job: a program of the library, or typed content. */
export type Source = Pick<Params<"job.start">, "program" | "text" | "format">;
export type Values = Readonly<Record<string, string>>;
type JobSource = Source & { setup?: Record<string, unknown> };

const CHECK_FAILED = -32004;
/** The program or its preset was replaced after the check. */
const PROGRAM_CHANGED = -32009;
/** Largest file that is checked automatically, bytes, since a check takes time. */
const AUTO_CHECK_LIMIT = 1024 * 1024;
const CHECK_DELAY = 400;
/** Range as users type it. */
const RANGE_PATTERN = /^([\d.]+)\s*(?:-|–|to|到)\s*([\d.]+)$/;
/** Of how many numbers an option is. */
const NUMBER_COUNTS: Partial<Record<Option["kind"], number>> = { number: 1, integer: 1, point: 2, place: 3, area: 4 };

const optionTables = new Map<string, Promise<Option[]>>();
/** Options of a format; requested from the station once. */
export function optionsOf(format: string): Promise<Option[]> {
  const table =
    optionTables.get(format) ??
    call("program.options", { format, all: true }).then((found) => found.options as Option[]);
  optionTables.set(format, table);
  table.catch(() => optionTables.delete(format));
  return table;
}

/** Value of an option for the station; undefined if empty, null if the text is invalid. */
function optionValue({ name, kind, usual, choices }: Option, typed: string | undefined): unknown {
  const text = (typed ?? "").trim();
  if (kind === "choice" && usual) return text || choices[0];
  if (text === "" || kind === "pens") return undefined;
  const count = NUMBER_COUNTS[kind];
  if (count !== undefined) {
    const numbers = parseNumbers(text, count);
    const [first] = numbers ?? [];
    if (kind === "integer" && !Number.isInteger(first)) return null;
    return count === 1 ? (first ?? null) : numbers;
  }
  if (kind === "switch") return text === "true";
  if (kind === "list") return text.split("\n");
  return name === "power" ? text.replace(/(\d),(?=\d)/g, "$1.").replace(RANGE_PATTERN, "$1..$2") : text;
}

/** Setup of these options for the station, without empty and invalid ones. */
export function setupOf(options: readonly Option[], values: Values): Record<string, unknown> {
  const set = options.map((option) => [option.name, optionValue(option, values[option.name])] as const);
  return Object.fromEntries(set.filter(([, value]) => value != null));
}

/** Reason why the text of an option is invalid, or null. */
export function optionFault(option: Option, typed: string | undefined): string | null {
  if (optionValue(option, typed) !== null) return null;
  const count = NUMBER_COUNTS[option.kind] ?? 1;
  return interpolate(
    optionText(option.kind === "integer" ? "said.whole" : count === 1 ? "said.number" : "said.numbers", ""),
    {
      count,
    },
  );
}

/** Refuses options with an invalid number, which would be ignored. */
export function requireValid(options: readonly Option[], values: Values): void {
  for (const option of options) {
    const fault = optionFault(option, values[option.name]);
    if (fault !== null) throw new Error(`${labelOf(option)}: ${fault}`);
  }
}

/** Entry of the library with this name. */
export const entryOf = (name: string | null | undefined): Entry | null =>
  programs.value.find((program) => program.name === name) ?? null;

/**
 * True if an option is relevant: the option it depends on must have one of the required values and
 * be relevant itself.
 */
export function isRelevant(
  { with: name, when }: Option,
  all: readonly Option[],
  said: (name: string) => string,
): boolean {
  if (name === null) return true;
  const other = all.find((one) => one.name === name);
  if (other !== undefined && !isRelevant(other, all, said)) return false;
  return when.length === 0 ? said(name) === "true" : when.includes(said(name));
}

export abstract class Workshop {
  abstract readonly chosen: ReadonlySignal<Source | null>;
  abstract readonly values: ReadonlySignal<Values>;
  /** Sets one option; an empty text leaves it to the station. */
  abstract setValue(name: string, to: string): void;
  /** Replaces all options. */
  abstract setValues(values: Values): void;
  /** Saves files in the library and takes them. */
  abstract openFiles(files: Iterable<File>): Promise<void>;

  readonly options = signal<Option[]>([]);
  readonly report = signal<Report | null>(null);
  /** Problem that prevents a check, or null. */
  readonly problem = signal<Problem | null>(null);
  readonly isChecking = signal(false);
  readonly isPreviewed = signal(false);
  /** Options that the workshop determines itself. */
  readonly fixed: Readonly<Record<string, unknown>>;
  readonly selected = computed(() => this.chosen.value?.program ?? null);
  readonly entry = computed<Entry | null>(() => entryOf(this.selected.value));
  protected checks = 0;
  /** Result of the newest check. */
  protected newestCheck: Promise<boolean> = Promise.resolve(false);

  constructor(fixed: Record<string, unknown> = {}) {
    this.fixed = fixed;
  }

  /** True if the user may set an option, because the workshop does not determine it. */
  isSettable(name: string): boolean {
    return !(name in this.fixed);
  }

  /** Value of an option; empty if the station decides. */
  valueOf = (name: string): string => {
    // Not asked for: the tool determines it.
    if (name === "work" && this.isSettable(name)) return this.valueOf("tool") === "laser" ? "engrave" : "draw";
    const option = this.options.value.find((one) => one.name === name);
    return String(this.fixed[name] ?? (this.values.value[name] || (option?.default ?? "")));
  };

  /** Options to ask for: relevant, and not determined by the workshop. */
  readonly shownOptions = computed(() =>
    this.options.value.filter(
      (option) => this.isSettable(option.name) && isRelevant(option, this.options.value, this.valueOf),
    ),
  );
  /** Values for the station; undefined if nothing is set. */
  readonly setup = computed<Record<string, unknown> | undefined>(() => {
    const set = { ...setupOf(this.shownOptions.value, this.values.value), ...this.fixed };
    return Object.keys(set).length > 0 ? set : undefined;
  });

  /** Source with its setup, as it would run now. */
  source(): JobSource {
    return { ...this.chosen.value, ...(this.setup.value ? { setup: this.setup.value } : {}) };
  }

  forget(): void {
    this.checks++;
    this.newestCheck = Promise.resolve(false);
    this.report.value = null;
    this.problem.value = null;
    this.isChecking.value = false;
    show("planned", []);
    this.isPreviewed.value = false;
  }

  /** Asks the station to check `source`. */
  protected async requestCheck(): Promise<Report | null> {
    requireValid(this.shownOptions.value, this.values.value);
    const mark = this.selectionKey();
    const report = await call("job.check", { ...shownArm(), ...this.source(), preview: true });
    this.checkedKey = mark;
    return report;
  }

  /**
   * Checks the program and shows a preview. True if the arm can run it. A check that is overtaken
   * returns the result of the newer one.
   */
  check = (): Promise<boolean> => (this.newestCheck = this.runCheck());

  private async runCheck(): Promise<boolean> {
    if (this.chosen.value === null) return false;
    const mine = ++this.checks;
    this.problem.value = null;
    this.isChecking.value = true;
    try {
      const found = await this.requestCheck();
      if (mine !== this.checks) return this.newestCheck;
      this.report.value = found;
      this.showPreview(found);
      return found?.ok === true;
    } catch (error) {
      if (mine !== this.checks) return this.newestCheck;
      this.forget();
      this.refuse(error);
      return false;
    } finally {
      if (mine === this.checks) this.isChecking.value = false;
    }
  }

  /** Shows the refusal of a check or a start: its report, or its sentence. */
  refuse(error: unknown): void {
    const found =
      error instanceof RpcError && error.code === CHECK_FAILED ? (error.data.report as Report | undefined) : undefined;
    if (found !== undefined) this.report.value = found;
    else this.problem.value = problemOf(error);
  }

  showPreview(found: Report | null): void {
    const { strokes, travels } = found?.preview ?? { strokes: [], travels: [] };
    const lines: Lines[] = strokes.map(({ points, height, reachable }) => ({
      points: points.map(([x = 0, y = 0]) => [x, y, height]),
      color: reachable ? "--planned" : "--stop",
    }));
    const ways = travels.map((points): Lines => ({ points, color: "--muted", opacity: 0.4 }));
    show("planned", [...lines, ...ways]);
    this.isPreviewed.value = lines.length + ways.length > 0;
  }

  /**
   * Starts the selected source with additional setup. `about` describes it to the user. Returns the
   * job.
   */
  start = async (
    title: string,
    about: () => string,
    more: Pick<jobs.Order, "loops" | "setup"> = {},
  ): Promise<string | null> => {
    let job: string | null = null;
    await attempt(async () => {
      const before = this.selectionKey();
      // A failed check is repeated, because the arm may stand elsewhere now.
      const isKnown = this.isSettled() && this.report.value?.ok === true;
      if (!isKnown && !(await this.check())) return;
      // The user has changed the selection meanwhile, and did not ask for the new one.
      if (this.selectionKey() !== before) return;
      // Runs what the user saw, even if another client replaces the program meanwhile.
      const seen = this.report.value?.digest;
      const order = { ...this.source(), ...(seen === undefined ? {} : { digest: seen }) };
      // Without any setup a program runs unchanged.
      const setup = order.setup || more.setup ? { setup: { ...order.setup, ...more.setup } } : {};
      try {
        job = await jobs.start({ ...order, ...more, ...setup }, title, about());
        if (job !== null && more.setup === undefined) this.onJobStarted(job);
        if (job !== null) await jobs.waitUntilKnown(job);
      } catch (error) {
        if (error instanceof RpcError && error.code === PROGRAM_CHANGED) await this.recheck();
        this.refuse(error);
      }
    });
    return job;
  };

  /** Shows a program that was replaced after its check. */
  private async recheck(): Promise<void> {
    await readLibrary();
    await this.check();
  }

  /** A job of what is chosen has begun. */
  protected onJobStarted(_job: string): void {}

  /** True if the last check belongs to the current selection. */
  protected isSettled(): boolean {
    return this.checkedKey === this.selectionKey();
  }
  protected checkedKey = "";

  /** Identifies the current selection and its options. */
  selectionKey(): string {
    return JSON.stringify([this.chosen.value, this.values.value, this.entry.value?.modified]);
  }

  /** Dependencies that make a new check necessary, besides the arm. */
  protected trackDependencies(): void {
    void this.setup.value;
    void this.values.value;
  }

  /** Size of the largest selected program, bytes; null if the library does not know it. */
  protected largestFile(): number | null {
    const found = this.entry.value;
    return found?.format === null ? null : (found?.bytes ?? 0);
  }

  /**
   * Checks changes automatically up to this size, while the panel is open and the arm has no job.
   */
  checkOnChange(most = AUTO_CHECK_LIMIT): () => void {
    let due: ReturnType<typeof setTimeout> | undefined;
    const end = effect(() => {
      const bytes = this.largestFile();
      const isIdle = store.isUp.value && !jobs.busy.value;
      this.trackDependencies();
      void knownSurface.value?.plane;
      void knownSurface.value?.sheet;
      void store.isHomed.value;
      clearTimeout(due);
      if (this.chosen.value === null || bytes === null) return;
      if (bytes > most) this.forget();
      else if (isIdle) due = setTimeout(() => void this.check(), CHECK_DELAY);
    });
    return () => {
      clearTimeout(due);
      end();
      show("planned", []);
      this.isPreviewed.value = false;
    };
  }

  /** Puts files into the library; under which names, and what they are called. */
  protected async storeFiles(files: Iterable<File>): Promise<Array<{ name: string; label: string }>> {
    const names: Array<{ name: string; label: string }> = [];
    for (const file of files) {
      await attempt(async () => {
        const name = await storeProgram(libraryName(file.name), file);
        if (name !== null) names.push({ name, label: file.name });
      });
    }
    return names;
  }
}

/** Workshop of the route *Run*: one program of the library, unchanged. */
export class RunWorkshop extends Workshop {
  readonly chosen = signal<Source | null>(null);
  readonly values = signal<Values>({});

  setValue(name: string, to: string): void {
    this.values.value = { ...this.values.value, [name]: to };
  }

  setValues(values: Values): void {
    this.values.value = values;
  }

  async select(name: string | null): Promise<void> {
    this.chosen.value = name === null ? null : { program: name };
    this.forget();
    this.options.value = [];
    this.values.value = {};
    const format = this.entry.value?.format;
    if (!format) return;
    try {
      const found = await optionsOf(format);
      if (this.entry.value?.format === format) this.options.value = found;
    } catch (error) {
      reportError(error);
    }
  }

  async openFiles(files: Iterable<File>): Promise<void> {
    const last = (await this.storeFiles(files)).at(-1);
    if (last !== undefined) await this.select(last.name);
  }
}
