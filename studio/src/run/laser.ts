// Whether the laser is armed: nothing is started that burns before a person has said so, for each job anew.
import { effect, signal } from "@preact/signals";
import * as store from "../store";
import { busy } from "./jobs";

export const isArmed = signal(false);

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
