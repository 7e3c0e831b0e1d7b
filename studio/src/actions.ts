// What people do, each as one call; what is refused is said.

import { queues, stopsAll } from "./class";
import type { Params } from "./client";
import { LINE_ENDED, RpcError } from "./client";
import { type Sentence, sentence, t, told } from "./i18n";
import { endJog } from "./jog";
import { log } from "./log";
import { call, giveBack, renamed, shown, takeControl } from "./session";
import { ownName, remember, remembered } from "./settings";
import * as store from "./store";

const DANGEROUS = -32005;
const STOPPED = -32007;

export function complain(error: unknown): void {
  if (error instanceof RpcError && error.code === STOPPED) return;
  const text = error instanceof RpcError ? inWords(error) : String((error as Error).message);
  log(text);
  store.say(text, true);
}

/** What the station answered, in the page's language; a sentence that has no other gets its kind in front there. */
export function inWords({ code, message, data }: RpcError): string {
  if (code === LINE_ENDED) return t("why.lost");
  const kind = told(`error.${code}`, "");
  const { template } = data as Sentence;
  if (template !== undefined && (kind === "" || told(template, "") !== "")) return sentence(data);
  return kind === "" ? message : `${kind}: ${message}`;
}

/** What to do about an error, as the station says it: an action, or an option with its value, or to leave one out. */
export interface Remedy {
  action?: string;
  option?: string;
  value?: unknown;
  without?: string;
  system?: string;
  effect?: string;
}
/** What keeps something from being done, and what to do about it. */
export interface Problem {
  text: string;
  remedies: readonly Remedy[];
}

export function problemOf(error: unknown): Problem {
  if (!(error instanceof RpcError)) return { text: String((error as Error).message), remedies: [] };
  const remedies = error.data.remedies;
  return { text: inWords(error), remedies: Array.isArray(remedies) ? (remedies as Remedy[]) : [] };
}

/** Stops the shown arm, or all of the station as the button says, and whatever the page holds. Never refused, never asked. */
export async function stop(all = stopsAll.value): Promise<void> {
  endJog("stopped");
  store.question.value?.answer(false);
  const arm = store.armName.value;
  try {
    await call("arm.stop", all || arm === null ? {} : { arm });
    store.say(t(all ? "stop.all" : "stop.done"));
  } catch (error) {
    if (error instanceof RpcError && error.code !== LINE_ENDED) return complain(error);
    const text = t("stop.unsent");
    log(text);
    store.say(text, true);
  }
}

export async function tried(work: () => Promise<unknown>): Promise<void> {
  try {
    await work();
  } catch (error) {
    complain(error);
  }
}

/** Asks for a name before control is taken, once a tab, where others see who has it: in a class, and at another computer's arm. */
async function named(): Promise<void> {
  const isOwn = ["localhost", "127.0.0.1", "[::1]"].includes(location.hostname);
  if (
    store.backend.value !== "station" ||
    store.pupil.value !== null ||
    ownName.value !== "" ||
    remembered("sessionStorage", "unnamed") !== null
  )
    return;
  if (isOwn && !queues.value) return;
  const name = await new Promise<string | null>((done) => (store.naming.value = done));
  if (name === null) return remember("sessionStorage", "unnamed", "yes");
  ownName.value = name;
  await renamed();
}

export const take = () =>
  tried(async () => {
    await named();
    if (store.lease.value === "other") {
      const name = store.holder.value?.name ?? "";
      const sure = await store.ask(t("take.title", { name }), t("take.text", { name }), t("lease.take"));
      if (!sure) return;
    }
    await takeControl();
  });
export const release = () =>
  tried(async () => {
    endJog("released");
    await giveBack();
  });
export const askFor = () =>
  tried(async () => {
    store.asking.value = true;
    try {
      const { granted } = await call("lease.ask", shown());
      if (!granted) store.say(t("lease.kept", { name: store.holder.value?.name ?? "" }));
    } finally {
      store.asking.value = false;
    }
  });
export const answer = (grant: boolean) =>
  tried(async () => {
    const asked = store.asked.value;
    store.asked.value = null;
    if (asked !== null) await call("lease.answer", { ...shown(), session: asked.session, grant });
  });

export const isReal = () => store.arm.value?.virtual === false;

export const home = () =>
  tried(async () => {
    if (isReal() && !(await store.ask(t("home.title"), t("home.text"), t("home")))) return;
    await agreed(t("home"), homed);
  });
/** Homes the shown arm; the page says so meanwhile. */
export async function homed(yes: { yes?: boolean } = {}): Promise<void> {
  const { arm } = shown();
  store.homing.value = arm;
  try {
    await call("arm.home", { arm, ...yes });
  } finally {
    if (store.homing.value === arm) store.homing.value = null;
  }
}
export const clearAlarms = () =>
  tried(() => agreed(t("alarms.clear"), (yes) => call("arm.clear_alarms", { ...shown(), ...yes })));

export const tool = (params: Omit<Params<"arm.tool">, "arm" | "yes">) =>
  tried(async () => {
    await call("arm.tool", { ...shown(), ...params });
    store.say(t("done"));
  });
export const laser = (on: boolean) =>
  tried(async () => {
    if (on && isReal() && !(await store.ask(t("laser.title"), t("laser.text"), t("laser.yes")))) return;
    await call("arm.tool", { ...shown(), laser: { on }, ...(on ? { yes: true } : {}) });
  });
export const speed = (percent: number) => tried(() => call("arm.speed", { ...shown(), percent }));

/** What a person has to agree to before it is done, if the station has refused it for that. */
export function dangerOf(error: unknown): string | null {
  if (!(error instanceof RpcError) || error.code !== DANGEROUS) return null;
  return t(error.data.danger === "laser" ? "danger.laser" : "danger.arm");
}

/** Once more with `yes` where the station says that it is dangerous and the person agrees. */
export async function agreed(what: string, work: (yes: { yes?: boolean }) => Promise<unknown>): Promise<void> {
  try {
    await work({});
  } catch (error) {
    const danger = dangerOf(error);
    if (danger === null) throw error;
    if (await store.ask(what, danger, what)) await work({ yes: true });
  }
}
