// Requests of the teach panel to the station: points, plans made of rows, jobs that play them,
// files.
import { computed, effect, signal } from "@preact/signals";
import { attempt } from "../actions";
import type { Plan, PlanStep } from "../api";
import type { StationNotification } from "../client";
import { t } from "../i18n";
import { save as download } from "../log";
import * as jobs from "../run/jobs";
import * as library from "../run/programs";
import { call, notificationListeners, shownArm } from "../session";
import * as store from "../store";
import { type Lines, show, target } from "../view/layers";
import * as program from "./rows";
import { w } from "./words";

/** Played job, with the index of each row's first step in its plan. */
const playing = signal<{ job: string; first: number[]; from: number } | null>(null);
/** Index of the row being played; null if no row is. */
export const playedRow = computed<number | null>(() => {
  const now = playing.value;
  const job = now === null ? undefined : jobs.jobs.value.find((one) => one.job === now.job);
  if (now === null || job === undefined || !jobs.isActive(job)) return null;
  return (
    now.from +
    Math.max(
      0,
      now.first.findLastIndex((first) => first <= job.step),
    )
  );
});
/** True if the unlock key of the arm adds points. */
export const addsByKey = signal(false);
export const loops = signal(1);
/** Wait of a new row at which the tool grips or releases, s: vacuum takes 0.3 s. */
export const toolWait = signal(0.5);
export const format = signal<"plan" | "playback">("plan");

function addStep(step: program.Motion): void {
  const before = program.rows.value[program.selected.value]?.motion as program.Motion | null | undefined;
  const { name: _, ...motion } = step;
  if (before?.move !== undefined && before.by !== undefined) motion.by = before.by;
  const { tool, rows } = program.taught.value;
  const mounted = store.state.value?.tool;
  program.add(motion, rows.length === 0 && tool === null ? { tool: mounted?.name ?? mounted?.bias ?? null } : {});
}

export const capture = () =>
  attempt(async () => addStep((await call("teach.capture", shownArm())).step as program.Motion));
export const reteach = (nth: number) =>
  attempt(async () => {
    const { step } = (await call("teach.capture", shownArm())) as {
      step: program.Motion & { move: number[]; by: string };
    };
    const { by } = (program.rows.value[nth]?.motion ?? {}) as program.Motion;
    program.edit(nth, { motion: { move: step.move, by: by ?? step.by } });
  });
export const addWait = () => {
  program.add(null);
  program.edit(program.selected.value, { wait: 1 });
};
export const addOutput = (address: number, high: boolean) =>
  attempt(async () => program.add((await call("teach.output", { address, high })).step as program.Motion));

export const setGuiding = (on: boolean) =>
  attempt(async () => {
    await call("teach.guide", { ...shownArm(), on });
    addsByKey.value = on;
  });

/** Listens for taught points while the panel is open. Returns a function that ends it. */
export function follow(): () => void {
  const hear = (...[method, params]: StationNotification) => {
    if (
      method !== "arm.event" ||
      params.arm !== store.armName.value ||
      params.event !== "hand-trigger" ||
      !addsByKey.value
    )
      return;
    const step = params.step as program.Motion;
    const last = program.rows.value[program.selected.value]?.motion as program.Motion | null | undefined;
    if (String(last?.move) !== String(step.move)) addStep(step);
  };
  notificationListeners.add(hear);
  const ends = [
    jobs.follow(),
    effect(showPoints),
    effect(() => {
      if (store.lease.value !== "mine") addsByKey.value = false;
    }),
  ];
  return () => {
    notificationListeners.delete(hear);
    for (const end of ends) end();
    if (addsByKey.value && store.why.value === null) void setGuiding(false);
    show("points", []);
    target.value = null;
  };
}

/** Shows the points in the picture. The selected one is larger. */
function showPoints(): void {
  const places = program.rows.value.map((row) => (row.motion as program.Motion | null)?.move);
  const points = places.filter((place) => place !== undefined).map((place) => place.slice(0, 3));
  const here = places[playedRow.value ?? program.selected.value];
  const lines: Lines[] = [
    { points, color: "--planned", opacity: 0.7 },
    { points, color: "--planned", dots: true },
  ];
  if (here !== undefined) lines.push({ points: [here.slice(0, 3)], color: "--accent", dots: true });
  show("points", points.length > 0 ? lines : []);
  const [x, y, z, r = 0] = here ?? [];
  target.value = x === undefined || y === undefined || z === undefined ? null : { x, y, z, r };
}

async function makePlan(rows = program.rows.value) {
  const { title, tool, surface } = program.taught.value;
  return call("teach.plan", {
    title: title || w("teach.untitled"),
    tool: tool as "none" | number[] | null,
    surface,
    rows: rows as Array<(typeof rows)[number] & { motion: PlanStep | null }>,
  });
}

/** Plays all rows, the rows from the selected one on, or only that one. */
export const play = (what: "all" | "from" | "one") =>
  attempt(async () => {
    const at = what === "all" ? 0 : program.selected.value;
    const row = program.rows.value[at];
    if (row === undefined) return;
    const only = what === "one";
    const { plan: made, first } = await makePlan(only ? [row] : undefined);
    const from = what === "from" ? { from: (first[at] ?? 0) + 1 } : {};
    // The same options as `magician teach` sets for a playback: untransformed points, and the tool
    // remains at the last one.
    const setup = { raw: true, stay: true };
    const order = {
      text: JSON.stringify(made),
      format: "plan",
      setup,
      ...from,
      ...(what === "all" ? { loops: loops.value } : {}),
    };
    const job = await jobs.start(order, program.taught.value.title || w("teach.untitled"), "");
    if (job === null) return;
    playing.value = { job, first, from: only ? at : 0 };
    await jobs.waitUntilKnown(job);
  });

/** Times at which this page saved programs. It may replace those without a question if nobody has changed them since. */
const savedTimes = new Map<string, number>();
const savedAt = (name: string) => library.programs.value.find((one) => one.name === name)?.modified;
const noteSaved = (name: string): void => void savedTimes.set(name, savedAt(name) ?? 0);
const fileName = () => library.libraryName(program.taught.value.title || w("teach.untitled"));

/** Saves the program in the library, where `#/run` lists it, and downloads it as a file. */
export const save = () =>
  attempt(async () => {
    const rows = program.rows.value;
    const { plan: made } = await makePlan();
    const head = `${JSON.stringify({ ...made, steps: undefined }).slice(0, -1)},"steps":[\n`;
    const steps = (made.steps as unknown[]).map((step) => JSON.stringify(step)).join(",\n");
    const text = `${head}${steps}\n]}\n`;
    const name = `${fileName()}.plan.json`;
    const to = `${fileName()}.playback`;
    const kept = format.value === "plan" ? [name] : [name, to];
    await library.readLibrary();
    for (const one of kept) if (savedTimes.get(one) !== savedAt(one) && !(await library.confirmReplace(one))) return;
    await library.storeProgram(name, new Blob([text]), true);
    noteSaved(name);
    if (format.value === "plan") {
      download(name, text);
    } else {
      const { lost } = await call("program.convert", { name, to });
      await library.readLibrary();
      noteSaved(to);
      const entry = library.programs.value.find((one) => one.name === to);
      if (entry) download(to, await library.fetchProgram(entry));
      if (lost.length > 0) store.notify(w("teach.lost", { what: lost.join("; ") }), true);
    }
    if (program.rows.value === rows) program.markSaved();
    store.notify(w("teach.saved", { name }));
  });

/** Converts a file to a plan by the station, under unused names that are deleted afterwards. */
async function convertFile(file: File): Promise<string | null> {
  const name = await library.unusedName(library.libraryName(file.name));
  const to = await library.unusedName(`${name.replace(/\.[^.]*$/, "").slice(0, 60)} opened.plan.json`);
  try {
    await library.storeProgram(name, file, true);
    await call("program.convert", { name, to });
    await library.readLibrary();
    const entry = library.programs.value.find((one) => one.name === to);
    return entry === undefined ? null : await (await library.fetchProgram(entry)).text();
  } finally {
    await library.readLibrary();
    const made = [to, name].filter((one) => library.programs.value.some((program) => program.name === one));
    await Promise.all(made.map((one) => call("program.delete", { name: one })));
  }
}

/** Replaces the program by that of a file. Can be undone. */
export const open = (file: File) =>
  attempt(async () => {
    let text = file.size < library.MAX_MESSAGE_BYTES ? await file.text() : "";
    if (!text.includes('"magician-plan"')) text = (await convertFile(file)) ?? "";
    if (text === "") return;
    const found = await call("teach.rows", { plan: JSON.parse(text) as Plan });
    if (!program.isSaved.value && !(await store.ask(w("teach.replace"), w("teach.replace.text"), t("replace")))) return;
    program.change(found, found.rows.length - 1);
    program.markSaved();
  });
