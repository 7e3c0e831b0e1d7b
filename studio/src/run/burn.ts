// Decides which jobs may burn, and refuses them until the user has armed the laser. Every start and
// resume of a job asks here.
import { signal } from "@preact/signals";
import type { Key } from "../i18n";
import * as shelf from "../shelf";
import * as store from "../store";

/** True while the user has armed the laser. Arming is for one job. */
export const isArmed = signal(false);

const KEPT = "burns";
/** Largest number of jobs remembered. */
const MOST = 60;
/** Use of the laser by a job of this page. A frame runs with the laser off and needs no arming. */
const KINDS = ["burns", "frame", "dark"] as const;
type Kind = (typeof KINDS)[number];
const isPair = (value: unknown): boolean =>
  shelf.isListOf(shelf.isText, 2)(value) && KINDS.includes((value as [string, Kind])[1]);
/** Jobs started by this page; survives a reload. */
const known = new Map<string, Kind>(shelf.kept("sessionStorage", KEPT, shelf.isListOf(isPair)) ?? []);

/** True if a job with this setup may burn. Without a tool in the setup the tool of the arm counts. */
export function mayBurn(setup: Readonly<Record<string, unknown>> | undefined): boolean {
  if (setup?.frame !== undefined) return false;
  const tool = setup?.tool;
  return (typeof tool === "string" ? tool : store.state.value?.tool.name) === "laser";
}

/** Remembers the kind of a job. */
export function keep(job: string, setup: Readonly<Record<string, unknown>> | undefined): void {
  known.set(job, mayBurn(setup) ? "burns" : setup?.frame === undefined ? "dark" : "frame");
  shelf.keep("sessionStorage", KEPT, [...known].slice(-MOST));
}

/** True if a job may burn. For jobs of other pages the tool of the arm decides. */
export const jobBurns = ({ job }: { job: string }): boolean =>
  known.has(job) ? known.get(job) === "burns" : mayBurn(undefined);
/** True if a job of this page only traces the outline. */
export const jobFrames = ({ job }: { job: string }): boolean => known.get(job) === "frame";

/** Reason why a job may not start or resume because of the laser. */
export const unarmed = (burns: boolean): Key | null => (burns && !isArmed.value ? "laser.unarmed" : null);
