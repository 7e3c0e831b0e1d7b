import { signal } from "@preact/signals";
import type { ComponentType } from "preact";
import { Move } from "../panels/move";
import { t } from "../i18n";
import * as store from "../store";
import { Dialogs } from "./dialogs";
import { Alarms, Header, LinkLost } from "./header";

/** Panels that come with the page, and those that come when they are opened. */
const panels = signal<Partial<Record<store.Route, ComponentType>>>({ move: Move });
const LATER: Partial<Record<store.Route, () => Promise<ComponentType>>> = {
  io: () => import("../panels/io").then((panel) => panel.Io),
  plots: () => import("../panels/plot").then((panel) => panel.Plots),
  world: () => import("../panels/world").then((panel) => panel.World),
  arms: () => import("../panels/arms").then((panel) => panel.Arms),
  settings: () => import("../panels/settings").then((panel) => panel.Settings),
};
const asked = new Set<store.Route>();

/** The panel of a route, once it is there. */
function panel(route: store.Route): ComponentType | undefined {
  const there = panels.value[route];
  if (there === undefined && !asked.has(route)) {
    asked.add(route);
    LATER[route]?.().then(
      (made) => (panels.value = { ...panels.value, [route]: made }),
      () => {
        asked.delete(route);
        store.say(t("panel.failed"), true);
      },
    );
  }
  return there;
}

export function App() {
  const route = store.route.value;
  const Panel = panel(route);
  store.shows.value = Panel !== undefined;
  return (
    <>
      <Header />
      <main class={`route-${route}`}>
        <h1 class="unseen">{`${t("app")}: ${t(`nav.${route}`)}`}</h1>
        <LinkLost />
        <Alarms />
        {Panel === undefined ? null : <Panel />}
      </main>
      <Dialogs />
    </>
  );
}
