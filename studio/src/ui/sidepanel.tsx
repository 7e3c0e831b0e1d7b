// Help and tour, which open beside or over the panel on every route.
import type { ComponentType } from "preact";
import { reportError } from "../actions";
import * as store from "../store";
import { lazy } from "./lazy";

const lazyPart = (load: () => Promise<ComponentType>) => lazy(load, undefined, reportError);
const Help = lazyPart(() => import("../help/help").then(({ Help }) => Help));
const Tour = lazyPart(() => import("../help/tour").then(({ Tour }) => Tour));

export function SidePanel() {
  const name = store.sidePanel.value;
  return name === "help" ? <Help /> : name === "tour" ? <Tour /> : null;
}
