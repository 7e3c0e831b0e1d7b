// Paper: its place, and what was drawn on it since it was laid there.
import { signal } from "@preact/signals";
import { reportError } from "../actions";
import type { Report } from "../api";
import { call, shownArm } from "../session";
import * as store from "../store";
import { until } from "../until";
import { type Frame, type Points, UPRIGHT } from "../view/flat";
import { drawn, readWorld, world } from "../view/world";
import * as jobs from "./jobs";
import { clusters } from "./room";
import { sheet } from "./surface";

/** Largest height above the table at which a pen counts as touching it, mm. */
const TOUCH_TOLERANCE = 1;

/** Lines that jobs of this page have left on the paper of real arms, by arm. */
const drawnByJobs = signal<ReadonlyMap<string, ReadonlyArray<{ points: Points; burnt: boolean }>>>(new Map());

const shownArmName = () => store.armName.value ?? "";
const isVirtual = () => store.arm.value?.virtual === true;

/**
 * Rotation of an upright drawing, degrees from the arm's x: for the reader of a measured sheet,
 * otherwise for the reader in front.
 */
export const uprightRotation = (): number => sheet.value?.rotation ?? UPRIGHT;
/**
 * Converts between the option `rotate` and the page's rotation, in which 0 is upright. With a
 * measured sheet both are equal, because `rotate` is then relative to the sheet.
 */
export const turnOf = (rotate: number): number => rotate - (sheet.value === null ? UPRIGHT : 0);
export const rotateOf = (turn: number): number => turn + (sheet.value === null ? UPRIGHT : 0);

/** Corners of the paper if known: measured, or the table of a virtual arm. */
export function corners(): Points | null {
  const outline = sheet.value?.outline ?? [];
  if (outline.length > 0) return outline;
  const table = isVirtual() ? world.value?.table : null;
  if (table == null) return null;
  const [[x0 = -1000, x1 = 1000], [y0 = -1000, y1 = 1000]] = [table.x, table.y];
  return [
    [x0, y0],
    [x1, y0],
    [x1, y1],
    [x0, y1],
  ];
}

/** Lines on the paper. */
export const strokes = (): ReadonlyArray<{ points: Points; burnt: boolean }> =>
  isVirtual() ? drawn.value.strokes : (drawnByJobs.value.get(shownArmName()) ?? []);
export const occupiedFrames = (): Frame[] => clusters(strokes().map(({ points }) => points));
export const isBlank = (): boolean => strokes().length === 0;

/** Adds lines of a job to the paper of a real arm. */
function addLines(name: string, lines: readonly Points[], burnt: boolean): void {
  const added = lines.map((points) => ({ points, burnt }));
  drawnByJobs.value = new Map(drawnByJobs.peek()).set(name, [...(drawnByJobs.peek().get(name) ?? []), ...added]);
}

/** Records the lines of a job of this page on the paper when the job ends, unless it failed. */
export async function recordWhenDone(
  bench: { report: { peek(): Report | null }; tool: string },
  started: Promise<string | null>,
): Promise<void> {
  const id = await started;
  const [report, name] = [bench.report.peek(), shownArmName()];
  if (id === null || report === null || isVirtual()) return;
  const lines = (report.preview?.strokes ?? []).map(({ points }) => points);
  const job = () => jobs.jobs.value.find((one) => one.job === id);
  await until(() => {
    const current = job();
    return current !== undefined && !jobs.isActive(current) && current.state !== "queued";
  });
  if (job()?.state !== "failed") addLines(name, lines, bench.tool === "laser");
}

/**
 * Height above the table at which a pen would draw, mm. Null if it draws on the table, on a real arm,
 * and for programs in arm coordinates, whose heights are chosen by their author.
 */
export function heightAboveTable(report: Report | null, tool: string, virtualWorld: typeof world.value): number | null {
  const table = virtualWorld?.table?.height;
  if (table === undefined || virtualWorld?.draws !== "pen" || tool !== "pen" || !isVirtual()) return null;
  if (report?.placed === undefined) return null;
  const heights = (report.preview?.strokes ?? []).map(({ height }) => height);
  const above = Math.min(...heights) - table;
  return heights.length > 0 && above > TOUCH_TOLERANCE ? above : null;
}

/**
 * Lays a new sheet: immediately for a virtual arm; for a real one the user confirms it. False if
 * refused.
 */
export async function layNewSheet(): Promise<boolean> {
  if (!isVirtual()) {
    const remaining = new Map(drawnByJobs.value);
    remaining.delete(shownArmName());
    drawnByJobs.value = remaining;
    return true;
  }
  try {
    await call("world.paper", shownArm());
  } catch (error) {
    reportError(error);
    return false;
  }
  await readWorld();
  return true;
}
