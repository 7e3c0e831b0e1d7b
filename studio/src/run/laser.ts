// Whether the laser is armed: nothing is started that burns before a person has said so, for each job anew.
import { effect, signal } from "@preact/signals";
import { leaveWith } from "../session";
import * as store from "../store";
import { busy, job } from "./jobs";

export const isArmed = signal(false);

/** The job that burns because a person has armed the laser here: it does not outlive the page. */
let burning: string | null = null;
effect(() => {
  if (isArmed.value && busy.value) burning = job.value?.job ?? null;
});
addEventListener("pagehide", () => {
  if (burning !== null && store.isBusy.value) leaveWith({ method: "job.stop", params: { job: burning } });
});

/** Disarms after each job, when the page is left or hidden, when control or the line is lost, and when this is called. */
export function watchArmed(): () => void {
  const disarm = () => (isArmed.value = false);
  let wasBusy = false;
  const ends = [
    effect(() => {
      const holds = store.isUp.value && store.lease.value === "mine";
      void store.armName.value;
      void store.session.value;
      if (!holds || (wasBusy && !busy.value)) disarm();
      wasBusy = busy.value;
    }),
  ];
  const hidden = () => document.hidden && disarm();
  document.addEventListener("visibilitychange", hidden);
  return () => {
    for (const end of ends) end();
    document.removeEventListener("visibilitychange", hidden);
    disarm();
  };
}
