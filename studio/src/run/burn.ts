// Decides which jobs may burn, and refuses them until the user has armed the laser. Every start and
// resume of a job asks here.
import { signal } from "@preact/signals";
import type { Key } from "../i18n";
import * as storage from "../storage";
import * as store from "../store";

/** True while the user has armed the laser. Arming is for one job. */
export const isArmed = signal(false);

const STORAGE_KEY = "burns";
/** Largest number of jobs remembered. */
const MAX_JOBS = 60;
/** Use of the laser by a job of this page. A frame runs with the laser off and needs no arming. */
const LASER_USES = ["burns", "frame", "dark"] as const;
type LaserUse = (typeof LASER_USES)[number];
const isPair = (value: unknown): boolean =>
  storage.isListOf(storage.isText, 2)(value) && LASER_USES.includes((value as [string, LaserUse])[1]);
/** Jobs started by this page; survives a reload. */
const laserUses = new Map<string, LaserUse>(
  storage.readStored("sessionStorage", STORAGE_KEY, storage.isListOf(isPair)) ?? [],
);

/** True if a job with this setup may burn. Without a tool in the setup the tool of the arm counts. */
export function mayBurn(setup: Readonly<Record<string, unknown>> | undefined): boolean {
  if (setup?.frame !== undefined) return false;
  const tool = setup?.tool;
  return (typeof tool === "string" ? tool : store.state.value?.tool.name) === "laser";
}

/** Remembers how a job uses the laser. */
export function rememberJob(job: string, setup: Readonly<Record<string, unknown>> | undefined): void {
  laserUses.set(job, mayBurn(setup) ? "burns" : setup?.frame === undefined ? "dark" : "frame");
  storage.writeStored("sessionStorage", STORAGE_KEY, [...laserUses].slice(-MAX_JOBS));
}

/** True if a job may burn. For jobs of other pages the tool of the arm decides. */
export const jobBurns = ({ job }: { job: string }): boolean =>
  laserUses.has(job) ? laserUses.get(job) === "burns" : mayBurn(undefined);
/** True if a job of this page only traces the outline. */
export const jobFrames = ({ job }: { job: string }): boolean => laserUses.get(job) === "frame";

/** Reason why a job may not start or resume because of the laser. */
export const whyUnarmed = (burns: boolean): Key | null => (burns && !isArmed.value ? "laser.unarmed" : null);
