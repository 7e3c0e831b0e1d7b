// Opens an example: the world that it needs round a virtual arm, its panel, and there it runs. A real arm does nothing before its person starts it.
import { computed } from "@preact/signals";
import { take, tried } from "../actions";
import { t } from "../i18n";
import { benches } from "../run/bench";
import * as check from "../run/check";
import * as library from "../run/programs";
import type { Shop } from "../run/shop";
import { connectSim } from "../session";
import * as store from "../store";
import * as teach from "../teach/actions";
import { load } from "../ui/routes";
import { until } from "../until";
import { loadBuiltIn } from "../view/seen";
import type { Example } from "./examples";

/** The page's own virtual arm is there within this, and the station tells who has control within that, ms. */
const [PATIENCE, SOON] = [30_000, 3000];

/** Whether an example runs by itself: only a virtual arm may be switched off and moved without a further question. */
export const runs = computed(() => store.backend.value === "none" || store.arm.value?.virtual === true);
/** Why none can be opened now. */
export const why = computed(() => {
  const reason = store.why.value;
  return store.backend.value === "none" || reason === "why.free" ? null : reason;
});

/** An arm, and control of it: the page's own where there is none. False if the person did not take control. */
async function ready(): Promise<boolean> {
  if (store.backend.value === "none") connectSim();
  if (!(await until(() => store.isUp.value && store.state.value !== null, PATIENCE))) throw new Error(t("why.lost"));
  // The page takes control of its own arm by itself.
  if (store.backend.value !== "sim" && store.lease.value === "free") await take();
  return (await until(() => store.lease.value === "mine", SOON)) && store.why.value === null;
}

async function contentOf({ name, text, url }: NonNullable<Example["file"]>): Promise<File> {
  return new File([text ?? (await (await fetch(url ?? "")).blob())], name);
}

/** The workshop of its panel, which has taken it. */
async function taken(example: Example, title: string): Promise<Shop> {
  if (example.panel !== "draw" && example.panel !== "engrave") {
    await check.run.select(title);
    return check.run;
  }
  const bench = benches[example.panel === "draw" ? "pen" : "laser"];
  bench.clear();
  if (example.file === undefined) bench.write(title);
  else bench.take(title);
  await bench.ready;
  return bench;
}

export const open = (example: Example) =>
  tried(async () => {
    if (!(await ready())) return;
    const plays = store.arm.value?.virtual === true && (await loadBuiltIn(example.world, false));
    location.hash = `#/${example.panel}`;
    await load(example.panel);
    const file = example.file === undefined ? null : await contentOf(example.file);
    if (example.panel === "teach" && file !== null) {
      await teach.open(file);
      if (plays) await teach.play("all");
      return;
    }
    const title = file === null ? (example.text ?? "") : await library.bring(file.name, file);
    const shop = await taken(example, title);
    for (const [name, value] of Object.entries(example.setup ?? {})) shop.setValue(name, value);
    if (plays && (await shop.check())) await shop.start(title, () => "");
  });
