// Jobs of the shown arm: followed while a panel shows them, and the user's actions on them.
import { computed, effect, signal } from "@preact/signals";
import { attempt, isReal, withConfirmation } from "../actions";
import type { Job } from "../api";
import type { Params, StationNotification } from "../client";
import { type Key, t } from "../i18n";
import { call, notificationListeners, shownArm } from "../session";
import * as store from "../store";
import { until } from "../until";
import { jobBurns, mayBurn, rememberJob, whyUnarmed } from "./burn";
import { noteRefusal, restartOrder, storeOrder } from "./restart";

/** Jobs, newest last, as the station sends them. */
export const jobs = signal<Job[]>([]);
const ACTIVE_STATES = ["checking", "running", "pausing", "paused", "stopping"];
const RESUMABLE_STATES = ["paused", "stopped", "failed", "interrupted"];
export const isActive = (job: Job): boolean => ACTIVE_STATES.includes(job.state);
export const canResume = (job: Job): boolean => RESUMABLE_STATES.includes(job.state);

/** Current job, otherwise the last one. */
export const job = computed<Job | null>(() => jobs.value.findLast(isActive) ?? jobs.value.at(-1) ?? null);
/** Time since the current job's remaining time was estimated, whole s; 0 unless the job runs. */
const estimateAge = signal(0);
/** The estimate, with the job and its state; the station estimates once a step. */
const estimate = computed(() => {
  const { job: id, state, seconds_left } = job.value ?? {};
  return `${id} ${state} ${seconds_left}`;
});
/** Remaining time of the current job, s; null if it is not known. It stands still unless the job runs. */
export const secondsLeft = ({ seconds_left }: Job): number | null =>
  seconds_left === null ? null : Math.max(0, seconds_left - estimateAge.value);
export const busy = computed(() => job.value !== null && isActive(job.value));
/** Name of another client that started the job; null otherwise. */
export const startedBy = (job: Job): string | null =>
  job.holder === null || !isActive(job) || job.holder.session === store.session.value ? null : job.holder.name;

/** Reason why jobs can be neither started nor controlled; a running job does not count. */
export const whyNoControl = computed(() => (store.why.value === "why.busy" ? null : store.why.value));
/** Why a job cannot be started now. */
export const whyNotStart = (setup?: Order["setup"]): Key | null =>
  whyNoControl.value ?? (busy.value ? "why.busy.job" : whyUnarmed(mayBurn(setup)));
/** True if someone other than the signed-in pupil started the job: the previous pupil or the teacher. */
export const isOfOthers = ({ holder }: Job): boolean =>
  store.pupil.value !== null && holder !== null && holder.name.toLowerCase() !== store.pupil.value.toLowerCase();
/** Why a job cannot go on now. */
export const whyNotResume = (of: Job): Key | null => whyNoControl.value ?? whyUnarmed(jobBurns(of));

/** True if the laser is armed or not needed. Otherwise shows the reason. */
function checkArmed(burns: boolean): boolean {
  const reason = whyUnarmed(burns);
  if (reason !== null) store.notify(t(reason));
  return reason === null;
}

let followers = 0;
let stopFollowing = () => {};

/** Follows the jobs, once for all callers. Returns a function that ends it. */
export function follow(): () => void {
  if (followers++ === 0) stopFollowing = startFollowing();
  return () => {
    if (--followers === 0) stopFollowing();
  };
}

function startFollowing(): () => void {
  const hear = (...[method, params]: StationNotification) => {
    if (method !== "job.changed" || params.job.arm !== store.armName.value) return;
    const changed = params.job;
    const at = jobs.value.findIndex((one) => one.job === changed.job);
    jobs.value = at < 0 ? [...jobs.value, changed] : jobs.value.with(at, changed);
  };
  notificationListeners.add(hear);
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
  const endCounting = effect(() => {
    void estimate.value;
    estimateAge.value = 0;
    if (job.peek()?.state !== "running") return;
    const at = performance.now();
    const timer = setInterval(() => (estimateAge.value = Math.floor((performance.now() - at) / 1000)), 1000);
    return () => clearInterval(timer);
  });
  return () => {
    notificationListeners.delete(hear);
    end();
    endCounting();
  };
}

export type Order = Pick<Params<"job.start">, "program" | "text" | "format" | "setup" | "from" | "loops" | "digest">;

/** Text to confirm before a real arm moves. */
const confirmationText = (about: string): string =>
  [about, store.backend.value === "serial" ? t("run.real.note") : ""].join(" ").trim();

/**
 * Starts a job, after the questions for a real arm and a laser. Returns its id, or null if the user
 * declined.
 */
export async function start(order: Order, title: string, about: string): Promise<string | null> {
  const burns = mayBurn(order.setup);
  if (!checkArmed(burns)) return null;
  if (isReal()) {
    const text = confirmationText(`${about} ${t("run.real.text")}`);
    if (!(await store.ask(t("run.real.title", { title }), text, t("run.start")))) return null;
  }
  let id: string | null = null;
  await withConfirmation(t("run.burns"), async (yes) => {
    id = (await call("job.start", { ...shownArm(), ...order, ...yes })).job;
    rememberJob(id, order.setup);
    storeOrder(id, order, title);
    // Earlier notices, such as a stop, are obsolete.
    store.notice.value = null;
  });
  return id;
}

/** A job that was started is known here soon after, ms. */
const KNOWN_TIMEOUT = 1000;
/** Until the page knows of a job: a button that started it is off from then on. */
export const waitUntilKnown = (id: string): Promise<boolean> =>
  until(() => jobs.value.some(({ job }) => job === id), KNOWN_TIMEOUT);

export const pause = (job: Job) => attempt(() => call("job.pause", { job: job.job }));
/** Stops the job, which lifts its pen; a stop of the arm does not. */
export const end = (job: Job) => attempt(() => call("job.stop", { job: job.job }));
export const resume = (job: Job) =>
  attempt(async () => {
    if (!checkArmed(jobBurns(job))) return;
    const name = job.holder?.name ?? "";
    if (isOfOthers(job) && !(await store.ask(t("run.theirs", { name }), t("run.theirs.text"), t("run.resume")))) return;
    if (
      isReal() &&
      !(await store.ask(
        t("run.resume.title", { title: job.title ?? "" }),
        confirmationText(t("run.resume.text")),
        t("run.resume"),
      ))
    )
      return;
    await withConfirmation(t("run.burns"), async (yes) => {
      await call("job.resume", { job: job.job, ...yes }).catch((error: unknown) => {
        noteRefusal(job.job, error);
        throw error;
      });
      store.notice.value = null;
    });
  });

/** Action that continues a job: resume, or restart if its progress is unknown. */
export function continuation(job: Job): { key: "run.resume" | "run.again"; press: () => Promise<unknown> } {
  const began = restartOrder(job);
  if (began === null) return { key: "run.resume", press: () => resume(job) };
  const again = async () => {
    const id = await start(began.order, began.title, "");
    if (id !== null) await waitUntilKnown(id);
  };
  return { key: "run.again", press: () => attempt(again) };
}

/** Progress over all loops, percent; null if they are endless or unknown. */
export function percentDone(job: Job): number | null {
  if (job.state === "done") return 100;
  if (!job.steps || !job.loops) return null;
  return Math.min(100, (100 * ((job.loop - 1) * job.steps + job.step)) / (job.steps * job.loops));
}

export function formatDuration(seconds: number): string {
  const whole = Math.max(0, Math.round(seconds));
  const two = (number: number) => String(number).padStart(2, "0");
  const [hours, minutes] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60];
  return hours > 0 ? `${hours}:${two(minutes)}:${two(whole % 60)}` : `${minutes}:${two(whole % 60)}`;
}
