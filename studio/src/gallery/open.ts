// Opens an example: its scenario around a virtual arm, and its panel, where it runs. On a real arm
// it waits for the user to start it.
import { computed } from "@preact/signals";
import { attempt, takeControl } from "../actions";
import { t } from "../i18n";
import { benches } from "../run/bench";
import * as check from "../run/check";
import * as library from "../run/programs";
import type { Workshop } from "../run/workshop";
import { connectSim } from "../session";
import * as store from "../store";
import * as teach from "../teach/actions";
import { loadPanel } from "../ui/routes";
import { until } from "../until";
import { loadBuiltIn } from "../view/world";
import type { Example } from "./examples";

/** Timeouts for the page's own virtual arm, and for the station to report who has control, ms. */
const [ARM_TIMEOUT, LEASE_TIMEOUT] = [30_000, 3000];

/**
 * True if an example may start by itself: only a virtual arm may be reset and moved without asking.
 */
export const canAutostart = computed(() => store.backend.value === "none" || store.arm.value?.virtual === true);
/** Reason why no example can be opened now; null if one can. */
export const whyNotOpen = computed(() => {
  const reason = store.why.value;
  return store.backend.value === "none" || reason === "why.free" ? null : reason;
});

/**
 * Provides an arm under control, by default the page's own. False if the user did not take control.
 */
async function prepareArm(): Promise<boolean> {
  if (store.backend.value === "none") connectSim();
  if (!(await until(() => store.isUp.value && store.state.value !== null, ARM_TIMEOUT))) throw new Error(t("why.lost"));
  // The page takes control of its arm automatically.
  if (store.backend.value !== "sim" && store.lease.value === "free") await takeControl();
  return (await until(() => store.lease.value === "mine", LEASE_TIMEOUT)) && store.why.value === null;
}

async function readExampleFile({ name, text, url }: NonNullable<Example["file"]>): Promise<File> {
  return new File([text ?? (await (await fetch(url ?? "")).blob())], name);
}

/** Workshop of the example's panel, with the example loaded. */
async function loadExample(example: Example, title: string): Promise<Workshop> {
  if (example.panel !== "draw" && example.panel !== "engrave") {
    await check.runWorkshop.select(title);
    return check.runWorkshop;
  }
  const bench = benches[example.panel === "draw" ? "pen" : "laser"];
  bench.clear();
  if (example.file === undefined) bench.write(title);
  else bench.take(title);
  await bench.ready;
  return bench;
}

export const openExample = (example: Example) =>
  attempt(async () => {
    if (!(await prepareArm())) return;
    const plays = store.arm.value?.virtual === true && (await loadBuiltIn(example.world, false));
    location.hash = `#/${example.panel}`;
    await loadPanel(example.panel);
    const file = example.file === undefined ? null : await readExampleFile(example.file);
    if (example.panel === "teach" && file !== null) {
      await teach.open(file);
      if (plays) await teach.play("all");
      return;
    }
    const title = file === null ? (example.text ?? "") : await library.storeUnused(file.name, file);
    const shop = await loadExample(example, title);
    for (const [name, value] of Object.entries(example.setup ?? {})) shop.setValue(name, value);
    if (plays && (await shop.check())) await shop.start(title, () => "");
  });
