// The job that the strip under the header tells of: the one under way, then how it ended, until it is closed.
import { computed, effect, signal } from "@preact/signals";
import type { Job } from "../api";
import * as jobs from "./jobs";

/** How long a job that ended well is told of while no hand is at the page, ms. */
const LINGERS = 10_000;
/** Ends that a person has not seen: the page, or the server, was away. */
const UNSEEN = ["interrupted"];

/** Jobs that this page saw under way, by their ids. */
const watched = signal<ReadonlySet<string>>(new Set());
const closed = signal<string | null>(null);

/** Whether a job is told of: one that was over before the page came is old news. */
export function isTold(job: Job, watched: ReadonlySet<string>, closed: string | null): boolean {
  if (jobs.isUnderWay(job)) return true;
  return job.job !== closed && (watched.has(job.job) || UNSEEN.includes(job.state));
}

/** Whether how it ended leaves nothing to read or do, so that it goes by itself. */
export const isPlain = (job: Job): boolean =>
  job.state === "done" && job.error === null && (job.notes ?? []).length === 0;

/** How long it took, s; null where it did not begin. */
export const took = ({ started, ended }: Job): number | null =>
  started === null || ended === null ? null : Math.max(0, ended - started);

export const told = computed<Job | null>(() => {
  const job = jobs.job.value;
  return job !== null && job.state !== "queued" && isTold(job, watched.value, closed.value) ? job : null;
});

export const close = (job: Job): void => void (closed.value = job.job);

/** Follows the job of the shown arm until what this gives back is called. */
export function follow(): () => void {
  let due: ReturnType<typeof setTimeout> | undefined;
  const wait = () => {
    clearTimeout(due);
    const job = told.peek();
    if (job !== null && isPlain(job)) due = setTimeout(() => close(job), LINGERS);
  };
  // What stands below moves up when it goes: not while a hand is about to press something.
  for (const event of ["pointerdown", "pointermove", "keydown"]) addEventListener(event, wait, { passive: true });
  const ends = [
    jobs.follow(),
    effect(() => {
      const job = jobs.job.value;
      if (job !== null && jobs.isUnderWay(job) && !watched.peek().has(job.job))
        watched.value = new Set([...watched.peek(), job.job]);
    }),
    effect(() => {
      void told.value;
      wait();
    }),
    () => clearTimeout(due),
    () => {
      for (const event of ["pointerdown", "pointermove", "keydown"]) removeEventListener(event, wait);
    },
  ];
  return () => ends.forEach((end) => end());
}
