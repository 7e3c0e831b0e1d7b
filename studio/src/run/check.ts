// Workshop of the open route, as its panels use it.
import { computed, type ReadonlySignal, signal } from "@preact/signals";
import { RunShop, type Shop } from "./shop";

export const run = new RunShop();
/** Workshop of the open route. */
export const shop = signal<Shop>(run);

type Inner<T> = T extends ReadonlySignal<infer V> ? V : never;
const of = <
  K extends
    | "chosen"
    | "selected"
    | "entry"
    | "values"
    | "options"
    | "report"
    | "problem"
    | "isChecking"
    | "isShown"
    | "asked"
    | "setup",
>(
  name: K,
) => computed(() => shop.value[name].value as Inner<Shop[K]>);

export const chosen = of("chosen");
export const selected = of("selected");
export const entry = of("entry");
export const values = of("values");
export const options = of("options");
export const report = of("report");
/** Problem that prevents a check, or null. */
export const problem = of("problem");
export const isChecking = of("isChecking");
export const isShown = of("isShown");
export const asked = of("asked");
export const setup = of("setup");

// biome-ignore lint/suspicious/noShadowRestrictedNames: nobody calls the one of objects
export const valueOf = (name: string): string => shop.value.valueOf(name);
export const setValue = (name: string, to: string): void => shop.value.setValue(name, to);
export const check = (): Promise<boolean> => shop.value.check();
export const openFiles = (files: Iterable<File>): Promise<void> => shop.value.openFiles(files);
