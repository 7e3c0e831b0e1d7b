// Jobs of the shown arm: followed while a panel shows them, and the user's actions on them.
import { computed, effect, signal } from "@preact/signals";
import { agreed, isReal, tried } from "../actions";
import type { Job } from "../api";
import type { Params, Told } from "../client";
import { type Key, t } from "../i18n";
import { call, notified, shown } from "../session";
import * as store from "../store";
import { until } from "../until";
import { hearRefusal, keepOrder, orderOf } from "./again";
import { jobBurns, keep, mayBurn, unarmed } from "./burn";

/** Jobs, newest last, as the station sends them. */
export const jobs = signal<Job[]>([]);
const UNDER_WAY = ["checking", "running", "pausing", "paused", "stopping"];
const RESUMED = ["paused", "stopped", "failed", "interrupted"];
export const isUnderWay = (job: Job): boolean => UNDER_WAY.includes(job.state);
export const canResume = (job: Job): boolean => RESUMED.includes(job.state);

/** Current job, otherwise the last one. */
export const job = computed<Job | null>(() => jobs.value.findLast(isUnderWay) ?? jobs.value.at(-1) ?? null);
export const busy = computed(() => job.value !== null && isUnderWay(job.value));
/** Name of another client that started the job; null otherwise. */
export const startedBy = (job: Job): string | null =>
  job.holder === null || !isUnderWay(job) || job.holder.session === store.session.value ? null : job.holder.name;

/** Reason why jobs can be neither started nor controlled; a running job does not count. */
export const why = computed(() => (store.why.value === "why.busy" ? null : store.why.value));
/** Why a job cannot be started now. */
export const whyNotStart = (setup?: Order["setup"]): Key | null =>
  why.value ?? (busy.value ? "why.busy.job" : unarmed(mayBurn(setup)));
/** True if someone other than the signed-in pupil started the job: the previous pupil or the teacher. */
export const isTheirs = ({ holder }: Job): boolean =>
  store.pupil.value !== null && holder !== null && holder.name.toLowerCase() !== store.pupil.value.toLowerCase();
/** Why a job cannot go on now. */
export const whyNotResume = (of: Job): Key | null => why.value ?? unarmed(jobBurns(of));

/** True if the laser is armed or not needed. Otherwise shows the reason. */
function isLet(burns: boolean): boolean {
  const reason = unarmed(burns);
  if (reason !== null) store.say(t(reason));
  return reason === null;
}

let followers = 0;
let unfollow = () => {};

/** Follows the jobs, once for all callers. Returns a function that ends it. */
export function follow(): () => void {
  if (followers++ === 0) unfollow = begin();
  return () => {
    if (--followers === 0) unfollow();
  };
}

function begin(): () => void {
  const hear = (...[method, params]: Told) => {
    if (method !== "job.changed" || params.job.arm !== store.armName.value) return;
    const changed = params.job;
    const at = jobs.value.findIndex((one) => one.job === changed.job);
    jobs.value = at < 0 ? [...jobs.value, changed] : jobs.value.with(at, changed);
  };
  notified.add(hear);
  let known: string | null = null;
  const end = effect(() => {
    const arm = store.armName.value;
    // While the station does not answer, a job may still be running: its last known state stays.
    if (arm === null || store.socket.value !== "up") return;
    if (arm !== known) jobs.value = [];
    known = arm;
    call("job.list", { arm }).then(
      ({ jobs: all }) => {
        if (store.armName.value === arm) jobs.value = all as Job[];
      },
      () => {},
    );
  });
  return () => {
    notified.delete(hear);
    end();
  };
}

export type Order = Pick<Params<"job.start">, "program" | "text" | "format" | "setup" | "from" | "loops" | "digest">;

/** Text to confirm before a real arm moves. */
const warned = (about: string): string =>
  [about, store.backend.value === "serial" ? t("run.real.note") : ""].join(" ").trim();

/**
 * Starts a job, after the questions for a real arm and a laser. Returns its id, or null if the user
 * declined.
 */
export async function start(order: Order, title: string, about: string): Promise<string | null> {
  const burns = mayBurn(order.setup);
  if (!isLet(burns)) return null;
  if (isReal()) {
    const text = warned(`${about} ${t("run.real.text")}`);
    if (!(await store.ask(t("run.real.title", { title }), text, t("run.start")))) return null;
  }
  let id: string | null = null;
  await agreed(t("run.burns"), async (yes) => {
    id = (await call("job.start", { ...shown(), ...order, ...yes })).job;
    keep(id, order.setup);
    keepOrder(id, order, title);
    // Earlier notices, such as a stop, are obsolete.
    store.notice.value = null;
  });
  return id;
}

/** A job that was started is known here soon after, ms. */
const KNOWN = 1000;
/** Until the page knows of a job: a button that started it is off from then on. */
export const heard = (id: string): Promise<boolean> => until(() => jobs.value.some(({ job }) => job === id), KNOWN);

export const pause = (job: Job) => tried(() => call("job.pause", { job: job.job }));
/** Stops the job, which lifts its pen; a stop of the arm does not. */
export const end = (job: Job) => tried(() => call("job.stop", { job: job.job }));
export const resume = (job: Job) =>
  tried(async () => {
    if (!isLet(jobBurns(job))) return;
    const name = job.holder?.name ?? "";
    if (isTheirs(job) && !(await store.ask(t("run.theirs", { name }), t("run.theirs.text"), t("run.resume")))) return;
    if (
      isReal() &&
      !(await store.ask(
        t("run.resume.title", { title: job.title ?? "" }),
        warned(t("run.resume.text")),
        t("run.resume"),
      ))
    )
      return;
    await agreed(t("run.burns"), async (yes) => {
      await call("job.resume", { job: job.job, ...yes }).catch((error: unknown) => {
        hearRefusal(job.job, error);
        throw error;
      });
      store.notice.value = null;
    });
  });

/** Action that continues a job: resume, or restart if its progress is unknown. */
export function goesOn(job: Job): { key: "run.resume" | "run.again"; press: () => Promise<unknown> } {
  const began = orderOf(job);
  if (began === null) return { key: "run.resume", press: () => resume(job) };
  const again = async () => {
    const id = await start(began.order, began.title, "");
    if (id !== null) await heard(id);
  };
  return { key: "run.again", press: () => tried(again) };
}

/** Progress over all loops, percent; null if they are endless or unknown. */
export function percent(job: Job): number | null {
  if (job.state === "done") return 100;
  if (!job.steps || !job.loops) return null;
  return Math.min(100, (100 * ((job.loop - 1) * job.steps + job.step)) / (job.steps * job.loops));
}

export function duration(seconds: number): string {
  const whole = Math.max(0, Math.round(seconds));
  const two = (number: number) => String(number).padStart(2, "0");
  const [hours, minutes] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60];
  return hours > 0 ? `${hours}:${two(minutes)}:${two(whole % 60)}` : `${minutes}:${two(whole % 60)}`;
}
