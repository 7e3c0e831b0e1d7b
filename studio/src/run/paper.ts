// What is known of the paper: where it lies, and what was drawn on it since it was laid there.
import { signal } from "@preact/signals";
import { complain } from "../actions";
import type { Report } from "../api";
import { call, shown } from "../session";
import * as store from "../store";
import { until } from "../until";
import { type Frame, type Points, UPRIGHT } from "../view/flat";
import { drawn, look, world } from "../view/seen";
import * as jobs from "./jobs";
import { clusters } from "./room";
import { sheet } from "./surface";

/** No pen reaches farther down than its tip, mm. */
const TOUCHES = 1;

/** Lines that jobs of this page have left on the paper of a real arm, by the arm. */
const left = signal<ReadonlyMap<string, ReadonlyArray<{ points: Points; burnt: boolean }>>>(new Map());

const arm = () => store.armName.value ?? "";
const isVirtual = () => store.arm.value?.virtual === true;

/** The turn that makes a drawing upright, in degrees from the arm's x: as the paper's reader sees it, else the one in front. */
export const upright = (): number => sheet.value?.rotation ?? UPRIGHT;
/** A turn as the page shows it, 0 being upright, from the option `rotate`; and back. A measured sheet is turned by itself. */
export const turnOf = (rotate: number): number => rotate - (sheet.value === null ? UPRIGHT : 0);
export const rotateOf = (turn: number): number => turn + (sheet.value === null ? UPRIGHT : 0);

/** The corners of the paper, if it is known where they are: measured, or the table of a virtual arm. */
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

/** What lies on the paper. */
export const strokes = (): ReadonlyArray<{ points: Points; burnt: boolean }> =>
  isVirtual() ? drawn.value.strokes : (left.value.get(arm()) ?? []);
export const taken = (): Frame[] => clusters(strokes().map(({ points }) => points));
export const isBlank = (): boolean => strokes().length === 0;

/** What a job of this page has drawn stays on the paper of a real arm. */
function leave(name: string, lines: readonly Points[], burnt: boolean): void {
  const more = lines.map((points) => ({ points, burnt }));
  left.value = new Map(left.peek()).set(name, [...(left.peek().get(name) ?? []), ...more]);
}

/** Remembers what a job of this page draws, once it is done. */
export async function follows(
  bench: { report: { peek(): Report | null }; tool: string },
  started: Promise<string | null>,
): Promise<void> {
  const id = await started;
  const [report, name] = [bench.report.peek(), arm()];
  if (id === null || report === null || isVirtual()) return;
  const lines = (report.preview?.strokes ?? []).map(({ points }) => points);
  const job = () => jobs.jobs.value.find((one) => one.job === id);
  await until(() => {
    const now = job();
    return now !== undefined && !jobs.isUnderWay(now) && now.state !== "queued";
  });
  if (job()?.state !== "failed") leave(name, lines, bench.tool === "laser");
}

/** How far above its table a pen would draw, mm, as far as a virtual arm can say; null where it draws on it. */
export function inAir(report: Report | null, tool: string, around: typeof world.value): number | null {
  const table = around?.table?.height;
  if (table === undefined || around?.draws !== "pen" || tool !== "pen" || !isVirtual()) return null;
  const heights = (report?.preview?.strokes ?? []).map(({ height }) => height);
  const above = Math.min(...heights) - table;
  return heights.length > 0 && above > TOUCHES ? above : null;
}

/** Lays a new sheet: of a virtual arm at once; of a real one it is taken at the person's word. False if it was refused. */
export async function lay(): Promise<boolean> {
  if (!isVirtual()) {
    const rest = new Map(left.value);
    rest.delete(arm());
    left.value = rest;
    return true;
  }
  try {
    await call("world.paper", shown());
  } catch (error) {
    complain(error);
    return false;
  }
  await look();
  return true;
}
