// Arming of the laser, and when it expires.
import { effect } from "@preact/signals";
import { leaveWith } from "../session";
import * as store from "../store";
import { isArmed } from "./burn";
import * as check from "./check";
import { busy, job } from "./jobs";

/** Job that burns because it was armed here. It must not outlive the page. */
let burning: string | null = null;
effect(() => {
  if (isArmed.value && busy.value) burning = job.value?.job ?? null;
});
addEventListener("pagehide", () => {
  if (burning !== null && store.isBusy.value) leaveWith({ method: "job.stop", params: { job: burning } });
});

/** Disarms after each job, when the panel or the page is left or hidden, when control or the line is lost, when another arm is shown, when
    what is to be burnt or its power becomes another, and when this is called. */
export function watchArmed(): () => void {
  const disarm = () => (isArmed.value = false);
  let [before, wasBusy] = ["", false];
  const end = effect(() => {
    const now = `${store.session.value} ${store.armName.value} ${store.route.value} ${check.shop.value.mark()}`;
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
