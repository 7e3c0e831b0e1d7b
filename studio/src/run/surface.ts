// Work surface and paper, measured by touching them with the tool.
import { computed, effect, signal } from "@preact/signals";
import { type Problem, problemOf } from "../actions";
import type { MeasuredSurface } from "../api";
import type { StationNotification } from "../client";
import { call, notificationListeners, shownArm } from "../session";
import * as store from "../store";
import { show } from "../view/layers";
import { w } from "./surface.words";

export type Corner = MeasuredSurface["corners"][number];
/** Corners as the reader in front of the arm sees them. The third one completes the sheet. */
export const CORNERS: readonly Corner[] = ["lower-left", "lower-right", "upper-left"];

/** Surface known to the station; null until it has answered. */
export const knownSurface = signal<MeasuredSurface | null>(null);
/** Height where it was touched, mm; null if unknown. */
export const height = computed<number | null>(() => knownSurface.value?.plane?.z ?? null);
export const sheet = computed(() => knownSurface.value?.sheet ?? null);
export const isKnown = computed(() => height.value !== null);
/** Reason why a touch was refused. */
export const problem = signal<Problem | null>(null);
/** True while the user measures the paper. */
export const isMeasuring = signal(false);
/** Corner to touch next. The user may choose another one, and repeat a corner. */
export const corner = signal<Corner>("lower-left");

/** Slope of a plane, degrees. */
export const tiltOf = ({ slope_x, slope_y }: NonNullable<MeasuredSurface["plane"]>): number =>
  (Math.atan(Math.hypot(slope_x, slope_y)) * 180) / Math.PI;

/** First corner that has not been touched. */
export const nextCorner = (taken: readonly Corner[]): Corner =>
  CORNERS.find((one) => !taken.includes(one)) ?? "lower-left";

async function requestSurface(
  ask: () => Promise<MeasuredSurface>,
  said: (found: MeasuredSurface) => string,
): Promise<void> {
  problem.value = null;
  try {
    const found = await ask();
    knownSurface.value = found;
    store.notify(said(found));
  } catch (error) {
    problem.value = problemOf(error);
  }
}

export const touch = (add = false) =>
  requestSurface(
    () => call("surface.touch", { ...shownArm(), ...(add ? { add } : {}) }),
    () => w("touch.done", { z: heightText() }),
  );
export const forget = () =>
  requestSurface(
    () => call("surface.touch", { ...shownArm(), forget: true }),
    () => w("touch.forgotten"),
  );
/** Forgets the surface without a message if nothing was measured. */
export async function forgetIfMeasured(): Promise<void> {
  const found = await call("surface.get", shownArm()).catch(() => null);
  if (found === null || (found.plane === null && found.corners.length === 0)) return;
  await forget();
}
export const takeCorner = () =>
  requestSurface(
    () => call("surface.corner", { ...shownArm(), corner: corner.value }),
    (found) => {
      if (found.corners.length > 0) corner.value = nextCorner(found.corners);
      else isMeasuring.value = false;
      return found.corners.length > 0
        ? w("paper.taken", { left: CORNERS.length - found.corners.length })
        : w("paper.done", { size: sizeText() });
    },
  );

/** Starts with the missing corners. */
export function measure(): void {
  problem.value = null;
  corner.value = nextCorner(knownSurface.value?.corners ?? []);
  isMeasuring.value = true;
  // On a phone it stands above the jog pad then.
  requestAnimationFrame(() =>
    document.querySelector(".paper-wizard")?.scrollIntoView({ block: innerWidth > 860 ? "nearest" : "start" }),
  );
}

export const heightText = (): string => (height.value === null ? "–" : `z ${height.value.toFixed(2)} mm`);
export const sizeText = (): string => {
  const [width = 0, high = 0] = sheet.value?.size ?? [];
  return `${Math.round(width)} × ${Math.round(high)} mm`;
};

/** Another page may measure as well: both continue with the corner that is missing. */
function onNotification(...[method, params]: StationNotification): void {
  if (method !== "surface.changed" || params.arm !== store.armName.value) return;
  knownSurface.value = params.surface;
  const { corners, sheet } = params.surface;
  if (isMeasuring.value && corners.includes(corner.value)) corner.value = nextCorner(corners);
  if (sheet !== null) isMeasuring.value = false;
}

/** Keeps the surface of the shown arm up to date. Returns a function that ends it. */
export function follow(): () => void {
  notificationListeners.add(onNotification);
  const ends = [
    () => notificationListeners.delete(onNotification),
    // A refusal concerns the arm's earlier state; it is requested again for another arm, or after
    // homing.
    effect(() => {
      void store.armName.value;
      void store.isHomed.value;
      problem.value = null;
    }),
    effect(() => {
      const arm = store.armName.value;
      knownSurface.value = null;
      isMeasuring.value = false;
      if (arm === null || store.socket.value !== "up") return;
      call("surface.get", { arm }).then(
        (found) => {
          if (store.armName.value === arm) knownSurface.value = found;
        },
        () => {},
      );
    }),
    effect(() => {
      const plane = knownSurface.value?.plane;
      const outline = sheet.value?.outline ?? [];
      const z = ([x, y]: [number, number]) =>
        plane ? plane.z + plane.slope_x * (x - plane.at[0]) + plane.slope_y * (y - plane.at[1]) : 0;
      const points = outline.map((at) => [...at, z(at) + 0.3]);
      show("sheet", points.length === 0 ? [] : [{ points, color: "--accent", closed: true }]);
    }),
    () => show("sheet", []),
  ];
  return () => ends.forEach((end) => end());
}
