// Strip below the header: shows the current job, and after its end the result, until the user
// closes it.
import { computed, effect, signal } from "@preact/signals";
import type { Job } from "../api";
import { readStored, writeStored } from "../storage";
import * as store from "../store";
import * as jobs from "./jobs";

/** Time for which a successful job stays without user activity, ms. */
const LINGER_TIME = 10_000;
/** Final states that a job reaches while its station is not running. */
const INTERRUPTED_STATES = ["interrupted"];
const STORAGE_KEY = "watched";
/** Number of jobs remembered over a reload. */
const MAX_REMEMBERED = 8;

/**
 * Ids of jobs that this tab saw running and whose end was not dismissed. Survives a reload, which may
 * itself have ended a job.
 */
const watched = signal<ReadonlySet<string>>(
  new Set(
    readStored(
      "sessionStorage",
      STORAGE_KEY,
      (value) => Array.isArray(value) && value.every((id) => typeof id === "string"),
    ) ?? [],
  ),
);
function setWatched(ids: ReadonlySet<string>): void {
  watched.value = ids;
  writeStored("sessionStorage", STORAGE_KEY, [...ids].slice(-MAX_REMEMBERED));
}
const dismissedJob = signal<string | null>(null);

/** True if the strip shows the job. A job that ended before the page was opened is not shown. */
export function isShown(job: Job, watched: ReadonlySet<string>, dismissed: string | null): boolean {
  if (jobs.isActive(job)) return true;
  return job.job !== dismissed && (watched.has(job.job) || INTERRUPTED_STATES.includes(job.state));
}

/** True if the end leaves nothing to read or do, so that the job disappears by itself. */
export const isUneventful = (job: Job): boolean =>
  job.state === "done" && job.error === null && (job.notes ?? []).length === 0;

/** Duration, s; null if the job did not begin or has not ended. */
export const durationOf = ({ started, ended }: Job): number | null =>
  started === null || ended === null ? null : Math.max(0, ended - started);

export const shownJob = computed<Job | null>(() => {
  const job = jobs.job.value;
  // The user can dismiss even an active job if the page has given up the connection: its state is
  // not updated any more.
  if (store.socket.value === "closed" && job?.job === dismissedJob.value) return null;
  return job !== null && job.state !== "queued" && isShown(job, watched.value, dismissedJob.value) ? job : null;
});

export function dismiss(job: Job): void {
  dismissedJob.value = job.job;
  setWatched(new Set([...watched.peek()].filter((id) => id !== job.job)));
}

/** Follows the job of the shown arm until the returned function is called. */
export function follow(): () => void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  const restartTimer = () => {
    clearTimeout(timer);
    const job = shownJob.peek();
    if (job !== null && isUneventful(job)) timer = setTimeout(() => dismiss(job), LINGER_TIME);
  };
  // Content moves up when the strip disappears, so that must not happen while the user is about to
  // press something.
  for (const event of ["pointerdown", "pointermove", "keydown"])
    addEventListener(event, restartTimer, { passive: true });
  const disposers = [
    jobs.follow(),
    effect(() => {
      const job = jobs.job.value;
      if (job !== null && jobs.isActive(job) && !watched.peek().has(job.job))
        setWatched(new Set([...watched.peek(), job.job]));
    }),
    effect(() => {
      void shownJob.value;
      restartTimer();
    }),
    () => clearTimeout(timer),
    () => {
      for (const event of ["pointerdown", "pointermove", "keydown"]) removeEventListener(event, restartTimer);
    },
  ];
  return () => disposers.forEach((dispose) => dispose());
}
