// Panels of the routes. All but the first are files of their own, loaded when they are opened.
import { signal } from "@preact/signals";
import type { ComponentType } from "preact";
import { t } from "../i18n";
import { Move } from "../panels/move";
import * as store from "../store";
import { lazy } from "./lazy";
import { Button } from "./parts";

const LAZY_PANELS: Partial<Record<store.Route, () => Promise<ComponentType>>> = {
  gallery: () => import("../panels/gallery").then(({ Gallery }) => Gallery),
  teach: () => import("../panels/teach").then(({ Teach }) => Teach),
  draw: () => import("../panels/draw").then(({ Draw }) => Draw),
  engrave: () => import("../panels/engrave").then(({ Engrave }) => Engrave),
  run: () => import("../panels/run").then(({ Run }) => Run),
  io: () => import("../panels/io").then(({ Io }) => Io),
  plots: () => import("../panels/plot").then(({ Plots }) => Plots),
  world: () => import("../panels/world").then(({ World }) => World),
  class: () => import("../panels/class").then(({ Class }) => Class),
  arms: () => import("../panels/arms").then(({ Arms }) => Arms),
  settings: () => import("../panels/settings").then(({ Settings }) => Settings),
};
const panels = signal<Partial<Record<store.Route, ComponentType>>>({ move: Move });
const failed = signal(false);

/** Loads the panel of a route. */
export async function loadPanel(route: store.Route): Promise<void> {
  if (panels.peek()[route] !== undefined) return;
  failed.value = false;
  try {
    const panel = await LAZY_PANELS[route]?.();
    if (panel !== undefined) panels.value = { ...panels.peek(), [route]: panel };
  } catch {
    failed.value = true;
  }
}

/**
 * The strip for jobs is loaded with the connection: to report the end of a job it must have
 * received the job's notifications.
 */
export const Strip = lazy(
  () => import("../panels/strip").then(({ JobStrip }) => JobStrip),
  () => store.socket.value === "up",
);

export function Panel() {
  const route = store.route.value;
  const Shown = panels.value[route];
  if (Shown !== undefined) return <Shown />;
  return failed.value ? (
    <p class="card">
      {t("route.failed")} <Button press={() => loadPanel(route)} text={t("route.again")} />
    </p>
  ) : null;
}
