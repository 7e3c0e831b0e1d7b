// Arming of the laser, and when it expires.
import { effect } from "@preact/signals";
import { sendOnClose } from "../session";
import * as store from "../store";
import { isArmed } from "./burn";
import * as check from "./check";
import { busy, job } from "./jobs";

/** Job that burns because it was armed here. It must not outlive the page. */
let burningJob: string | null = null;
effect(() => {
  if (isArmed.value && busy.value) burningJob = job.value?.job ?? null;
});
addEventListener("pagehide", () => {
  if (burningJob !== null && store.isBusy.value) sendOnClose({ method: "job.stop", params: { job: burningJob } });
});

/**
 * Disarms after each job, and when the panel or page is left or hidden, control or the connection is
 * lost, another arm is shown, or the drawing or its power changes. Also disarms when called.
 */
export function watchArmed(): () => void {
  const disarm = () => (isArmed.value = false);
  let [before, wasBusy] = ["", false];
  const end = effect(() => {
    const now = `${store.session.value} ${store.armName.value} ${store.route.value} ${check.openWorkshop.value.selectionKey()}`;
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
