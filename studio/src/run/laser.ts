// Arming of the laser: a job that burns can only start after the user has armed it, for each job
// anew.
import { effect, signal } from "@preact/signals";
import { leaveWith } from "../session";
import * as store from "../store";
import { busy, job } from "./jobs";

export const isArmed = signal(false);

/** Job that burns because it was armed here. It must not outlive the page. */
let burning: string | null = null;
effect(() => {
  if (isArmed.value && busy.value) burning = job.value?.job ?? null;
});
addEventListener("pagehide", () => {
  if (burning !== null && store.isBusy.value) leaveWith({ method: "job.stop", params: { job: burning } });
});

/**
 * Disarms after each job, when the page is left or hidden, when control or the connection is lost,
 * and when another arm is shown. Returns a function that disarms and ends this.
 */
export function watchArmed(): () => void {
  const disarm = () => (isArmed.value = false);
  let [before, wasBusy] = ["", false];
  const end = effect(() => {
    const now = `${store.session.value} ${store.armName.value}`;
    const holds = store.isUp.value && store.lease.value === "mine";
    if (!holds || now !== before || (wasBusy && !busy.value)) disarm();
    [before, wasBusy] = [now, busy.value];
  });
  const over = new AbortController();
  document.addEventListener("visibilitychange", () => document.hidden && disarm(), over);
  return () => {
    end();
    over.abort();
    disarm();
  };
}
