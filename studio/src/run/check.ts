// Workshop of the open route, as its panels use it.
import { computed, type ReadonlySignal, signal } from "@preact/signals";
import { RunWorkshop, type Workshop } from "./workshop";

export const runWorkshop = new RunWorkshop();
/** Workshop of the open route. */
export const openWorkshop = signal<Workshop>(runWorkshop);

type Inner<T> = T extends ReadonlySignal<infer V> ? V : never;
const fromWorkshop = <
  K extends
    | "chosen"
    | "selected"
    | "entry"
    | "values"
    | "options"
    | "report"
    | "problem"
    | "isChecking"
    | "isPreviewed"
    | "shownOptions"
    | "setup",
>(
  name: K,
) => computed(() => openWorkshop.value[name].value as Inner<Workshop[K]>);

export const chosen = fromWorkshop("chosen");
export const selected = fromWorkshop("selected");
export const entry = fromWorkshop("entry");
export const values = fromWorkshop("values");
export const options = fromWorkshop("options");
export const report = fromWorkshop("report");
/** Problem that prevents a check, or null. */
export const problem = fromWorkshop("problem");
export const isChecking = fromWorkshop("isChecking");
export const isPreviewed = fromWorkshop("isPreviewed");
export const shownOptions = fromWorkshop("shownOptions");
export const setup = fromWorkshop("setup");

// biome-ignore lint/suspicious/noShadowRestrictedNames: nobody calls the one of objects
export const valueOf = (name: string): string => openWorkshop.value.valueOf(name);
export const setValue = (name: string, to: string): void => openWorkshop.value.setValue(name, to);
export const check = (): Promise<boolean> => openWorkshop.value.check();
export const openFiles = (files: Iterable<File>): Promise<void> => openWorkshop.value.openFiles(files);
