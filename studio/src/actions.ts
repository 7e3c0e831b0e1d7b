// User actions, each as one call. Refusals are shown to the user.

import { queuesPrograms, stopsAll } from "./class";
import type { Params } from "./client";
import { CONNECTION_ENDED, RpcError } from "./client";
import { type Sentence, sentence, t, translated } from "./i18n";
import { endJog } from "./jog";
import { log } from "./log";
import { applyNameAndWait, call, releaseLease, shownArm, takeLease } from "./session";
import { ownName, readValue, writeValue } from "./settings";
import * as store from "./store";

const DANGEROUS_CODE = -32005;
const STOPPED_CODE = -32007;

export function reportError(error: unknown): void {
  if (error instanceof RpcError && error.code === STOPPED_CODE) return;
  const text = error instanceof RpcError ? errorText(error) : String((error as Error).message);
  log(text);
  store.notify(text, true);
}

/**
 * Error of the station in the page's language. A sentence without a translation is preceded by its
 * kind.
 */
export function errorText({ code, message, data }: RpcError): string {
  if (code === CONNECTION_ENDED) return t("why.lost");
  const kind = translated(`error.${code}`, "");
  const { template } = data as Sentence;
  if (template !== undefined && (kind === "" || translated(template, "") !== "")) return sentence(data);
  return kind === "" ? message : `${kind}: ${message}`;
}

/**
 * Remedy of an error as the station sends it: an action, an option with a value, or an option to
 * omit.
 */
export interface Remedy {
  action?: string;
  option?: string;
  value?: unknown;
  without?: string;
  system?: string;
  effect?: string;
}
/** Reason why something cannot be done, with its remedies. */
export interface Problem {
  text: string;
  remedies: readonly Remedy[];
}

export function problemOf(error: unknown): Problem {
  if (!(error instanceof RpcError)) return { text: String((error as Error).message), remedies: [] };
  const remedies = error.data.remedies;
  return { text: errorText(error), remedies: Array.isArray(remedies) ? (remedies as Remedy[]) : [] };
}

/**
 * Stops the shown arm, or all arms of the station if the button says so. Also ends the page's jog
 * and closes an open question. Needs no lease and no confirmation.
 */
export async function stop(all = stopsAll.value): Promise<void> {
  endJog("stopped");
  store.question.value?.answer(false);
  const arm = store.armName.value;
  try {
    await call("arm.stop", all || arm === null ? {} : { arm });
    store.notify(t(all ? "stop.all" : "stop.done"));
  } catch (error) {
    if (error instanceof RpcError && error.code !== CONNECTION_ENDED) return reportError(error);
    const text = t("stop.unsent");
    log(text);
    store.notify(text, true);
  }
}

export async function attempt(work: () => Promise<unknown>): Promise<void> {
  try {
    await work();
  } catch (error) {
    reportError(error);
  }
}

/**
 * Asks for the user's name before control is taken, once per tab, if other users see the holder's
 * name: in a class, or at a station of another computer.
 */
async function askForName(): Promise<void> {
  const isOwn = ["localhost", "127.0.0.1", "[::1]"].includes(location.hostname);
  if (
    store.backend.value !== "station" ||
    store.pupil.value !== null ||
    ownName.value !== "" ||
    readValue("sessionStorage", "unnamed") !== null
  )
    return;
  if (isOwn && !queuesPrograms.value) return;
  const name = await new Promise<string | null>((done) => (store.namePrompt.value = done));
  if (name === null) return writeValue("sessionStorage", "unnamed", "yes");
  ownName.value = name;
  await applyNameAndWait();
}

export const takeControl = () =>
  attempt(async () => {
    await askForName();
    if (store.lease.value === "other") {
      const name = store.holder.value?.name ?? "";
      const isConfirmed = await store.ask(t("take.title", { name }), t("take.text", { name }), t("lease.take"));
      if (!isConfirmed) return;
    }
    await takeLease();
  });
export const releaseControl = () =>
  attempt(async () => {
    endJog("released");
    await releaseLease();
  });
export const askForControl = () =>
  attempt(async () => {
    store.isRequestingControl.value = true;
    try {
      const { granted } = await call("lease.ask", shownArm());
      if (!granted) store.notify(t("lease.kept", { name: store.holder.value?.name ?? "" }));
    } finally {
      store.isRequestingControl.value = false;
    }
  });
export const answerControlRequest = (grant: boolean) =>
  attempt(async () => {
    const request = store.controlRequest.value;
    store.controlRequest.value = null;
    if (request !== null) await call("lease.answer", { ...shownArm(), session: request.session, grant });
  });

export const isReal = () => store.arm.value?.virtual === false;

export const home = () =>
  attempt(async () => {
    if (isReal() && !(await store.ask(t("home.title"), t("home.text"), t("home")))) return;
    await withConfirmation(t("home"), homeShownArm);
  });
/** Homes the shown arm. `store.homing` is the arm meanwhile. */
export async function homeShownArm(yes: { yes?: boolean } = {}): Promise<void> {
  const { arm } = shownArm();
  store.homing.value = arm;
  try {
    await call("arm.home", { arm, ...yes });
  } finally {
    if (store.homing.value === arm) store.homing.value = null;
  }
}
export const clearAlarms = () =>
  attempt(() => withConfirmation(t("alarms.clear"), (yes) => call("arm.clear_alarms", { ...shownArm(), ...yes })));

export const setTool = (params: Omit<Params<"arm.tool">, "arm" | "yes">) =>
  attempt(async () => {
    await call("arm.tool", { ...shownArm(), ...params });
    store.notify(t("done"));
  });
export const setLaser = (on: boolean) =>
  attempt(async () => {
    if (on && isReal() && !(await store.ask(t("laser.title"), t("laser.text"), t("laser.yes")))) return;
    await call("arm.tool", { ...shownArm(), laser: { on }, ...(on ? { yes: true } : {}) });
  });
export const setSpeed = (percent: number) => attempt(() => call("arm.speed", { ...shownArm(), percent }));

/**
 * Question to confirm before the action is repeated, if the station refused it as dangerous; null
 * otherwise.
 */
export function dangerQuestion(error: unknown): string | null {
  if (!(error instanceof RpcError) || error.code !== DANGEROUS_CODE) return null;
  return t(error.data.danger === "laser" ? "danger.laser" : "danger.arm");
}

/** Runs `work`, and again with `yes` if the station calls it dangerous and the user agrees. */
export async function withConfirmation(
  title: string,
  work: (yes: { yes?: boolean }) => Promise<unknown>,
): Promise<void> {
  try {
    await work({});
  } catch (error) {
    const danger = dangerQuestion(error);
    if (danger === null) throw error;
    if (await store.ask(title, danger, title)) await work({ yes: true });
  }
}
