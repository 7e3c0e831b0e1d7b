// Help and tour, which open beside or over the panel on every route.
import type { ComponentType } from "preact";
import { complain } from "../actions";
import * as store from "../store";
import { later } from "./later";

const part = (load: () => Promise<ComponentType>) => later(load, undefined, complain);
const Help = part(() => import("../help/help").then(({ Help }) => Help));
const Tour = part(() => import("../help/tour").then(({ Tour }) => Tour));

export function Beside() {
  const name = store.beside.value;
  return name === "help" ? <Help /> : name === "tour" ? <Tour /> : null;
}
