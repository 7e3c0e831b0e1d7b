// Job in the strip below the header: the current one, then how it ended, until it is closed.
import { computed, effect, signal } from "@preact/signals";
import type { Job } from "../api";
import { keep, kept } from "../shelf";
import * as store from "../store";
import * as jobs from "./jobs";

/** Time for which a successful job stays without user activity, ms. */
const LINGERS = 10_000;
/** Ends that happened while the server was away. */
const UNSEEN = ["interrupted"];
const WATCHED = "watched";
/** Number of jobs remembered over a reload. */
const REMEMBERED = 8;

/**
 * Ids of jobs that this tab saw running and whose end was not dismissed. Survives a reload, which may
 * itself have ended a job.
 */
const watched = signal<ReadonlySet<string>>(
  new Set(
    kept("sessionStorage", WATCHED, (value) => Array.isArray(value) && value.every((id) => typeof id === "string")) ??
      [],
  ),
);
function watch(ids: ReadonlySet<string>): void {
  watched.value = ids;
  keep("sessionStorage", WATCHED, [...ids].slice(-REMEMBERED));
}
const closed = signal<string | null>(null);

/** True if the strip shows the job. A job that ended before the page was opened is not shown. */
export function isTold(job: Job, watched: ReadonlySet<string>, closed: string | null): boolean {
  if (jobs.isUnderWay(job)) return true;
  return job.job !== closed && (watched.has(job.job) || UNSEEN.includes(job.state));
}

/** True if the end leaves nothing to read or do, so that the job disappears by itself. */
export const isPlain = (job: Job): boolean =>
  job.state === "done" && job.error === null && (job.notes ?? []).length === 0;

/** Duration, s; null if the job did not begin. */
export const took = ({ started, ended }: Job): number | null =>
  started === null || ended === null ? null : Math.max(0, ended - started);

export const told = computed<Job | null>(() => {
  const job = jobs.job.value;
  // A job without news can be dismissed once the page has given up the connection.
  if (store.socket.value === "closed" && job?.job === closed.value) return null;
  return job !== null && job.state !== "queued" && isTold(job, watched.value, closed.value) ? job : null;
});

export function close(job: Job): void {
  closed.value = job.job;
  watch(new Set([...watched.peek()].filter((id) => id !== job.job)));
}

/** Follows the job of the shown arm. Returns a function that ends it. */
export function follow(): () => void {
  let due: ReturnType<typeof setTimeout> | undefined;
  const wait = () => {
    clearTimeout(due);
    const job = told.peek();
    if (job !== null && isPlain(job)) due = setTimeout(() => close(job), LINGERS);
  };
  // Content moves up when the strip disappears, so that must not happen while the user is about to
  // press something.
  for (const event of ["pointerdown", "pointermove", "keydown"]) addEventListener(event, wait, { passive: true });
  const ends = [
    jobs.follow(),
    effect(() => {
      const job = jobs.job.value;
      if (job !== null && jobs.isUnderWay(job) && !watched.peek().has(job.job))
        watch(new Set([...watched.peek(), job.job]));
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
