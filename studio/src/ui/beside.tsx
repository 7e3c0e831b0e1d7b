// What opens beside the panel or over it, on every route: each is a file of its own that comes when it is opened.
import { effect, signal } from "@preact/signals";
import type { ComponentType } from "preact";
import { complain } from "../actions";
import * as store from "../store";

const PARTS: Record<store.Beside, () => Promise<ComponentType>> = {
  help: () => import("../help/help").then(({ Help }) => Help),
  tour: () => import("../help/tour").then(({ Tour }) => Tour),
};
const shown = signal<{ name: store.Beside; Part: ComponentType } | null>(null);
effect(() => {
  const name = store.beside.value;
  if (name === null) return;
  PARTS[name]().then((Part) => {
    shown.value = { name, Part };
  }, complain);
});

export function Beside() {
  const now = shown.value;
  return now === null || now.name !== store.beside.value ? null : <now.Part />;
}
