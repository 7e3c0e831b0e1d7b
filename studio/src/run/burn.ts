// Decides which jobs may burn, and refuses them until the user has armed the laser. Every start and
// resume of a job asks here.
import { signal } from "@preact/signals";
import type { Key } from "../i18n";
import { remember, remembered } from "../settings";
import * as store from "../store";

/** Whether the laser is armed: a person says so, for each job anew. */
export const isArmed = signal(false);

const KEPT = "burns";
/** As many jobs are remembered. */
const MOST = 60;
/** What a job of this page does with the laser: it goes round with the laser off, which takes no armed one. */
type Kind = "burns" | "frame" | "dark";
/** The jobs that this page has started: kept over a reload. */
const known = new Map<string, Kind>(read());

function read(): [string, Kind][] {
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

/** Remembers of a job with this setup what it does. */
export function keep(job: string, setup: Readonly<Record<string, unknown>> | undefined): void {
  known.set(job, mayBurn(setup) ? "burns" : setup?.frame === undefined ? "dark" : "frame");
  remember("sessionStorage", KEPT, JSON.stringify([...known].slice(-MOST)));
}

/** Whether a job may burn: of one that another page has started, as the tool of the arm says. */
export const jobBurns = ({ job }: { job: string }): boolean =>
  known.has(job) ? known.get(job) === "burns" : mayBurn(undefined);
/** Whether a job of this page only goes round what would be burnt, or drawn. */
export const jobFrames = ({ job }: { job: string }): boolean => known.get(job) === "frame";

/** Why something cannot begin, or go on, as far as the laser says. */
export const unarmed = (burns: boolean): Key | null => (burns && !isArmed.value ? "laser.unarmed" : null);
