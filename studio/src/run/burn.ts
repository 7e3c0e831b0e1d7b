// What burns, and whether a person has armed the laser for it: asked at every door by which a job begins or goes on.
import { signal } from "@preact/signals";
import type { Key } from "../i18n";
import { remember, remembered } from "../settings";
import * as store from "../store";

/** Whether the laser is armed: a person says so, for each job anew. */
export const isArmed = signal(false);

const KEPT = "burns";
/** As many jobs are remembered. */
const MOST = 60;
/** Jobs that this page has started, and whether they burn: kept over a reload. */
const known = new Map<string, boolean>(read());

function read(): [string, boolean][] {
  try {
    return JSON.parse(remembered("sessionStorage", KEPT) ?? "[]");
  } catch {
    return [];
  }
}

/** Whether what has this setup may burn. What does not say its tool has that of the arm; a frame is gone round with the laser off. */
export function mayBurn(setup: Readonly<Record<string, unknown>> | undefined): boolean {
  if (setup?.frame !== undefined) return false;
  const tool = setup?.tool;
  return (typeof tool === "string" ? tool : store.state.value?.tool.name) === "laser";
}

/** Remembers of a job whether it may burn. */
export function keep(job: string, burns: boolean): void {
  known.set(job, burns);
  remember("sessionStorage", KEPT, JSON.stringify([...known].slice(-MOST)));
}

/** Whether a job may burn: of one that another page has started, as the tool of the arm says. */
export const jobBurns = ({ job }: { job: string }): boolean => known.get(job) ?? mayBurn(undefined);

/** Why something cannot begin, or go on, as far as the laser says. */
export const unarmed = (burns: boolean): Key | null => (burns && !isArmed.value ? "laser.unarmed" : null);
