// Session with a station: connects, keeps it alive, reconnects, and puts notifications into the
// store.
import { batch } from "@preact/signals";
import type { Holder, Job, State } from "./api";
import { NO_WORKER, PORT_BUSY, PORT_GONE, PORT_SILENT, SERIAL, SIM, type ToWorker, type Wire } from "./carrier";
import { Client, LINE_ENDED, type Method, type Params, type Result, RpcError, type Told } from "./client";
import { t } from "./i18n";
import { log } from "./log";
import { isPin } from "./pairing";
import { choose } from "./serial";
import { lastArm, ownName, remember, rememberedAs, used } from "./settings";
import * as store from "./store";
import { until } from "./until";

/** Rate of state notifications, Hz. */
const RATE = 20;
/** Backoff before a reconnection, ms. The last pause repeats. */
const PAUSES = [200, 400, 800, 1600, 3200, 5000];
const STALE = 1000;
/**
 * Silence after which the station is asked for a message, ms. After the same time without an answer
 * the connection counts as dead.
 */
const SILENT = 1500;
/**
 * The same limit for a station in the worker, ms, which cannot answer while it checks a program.
 */
const CHECKING = 60_000;
/** Further silence after which a worker with a real arm is terminated, ms. */
const DEAD = 8000;
/**
 * Pause before a full station is tried again, ms. Up to half as much is added at random, so that
 * pages refused together do not return together.
 */
const FULL_AGAIN = 15_000;
const RESUME = "resume";
/** A token is kept until the tab is closed, since tablets are shared. */
const TOKEN = "token";
const PUPIL = "pupil";
/** Patterns of secrets and names. The station closes the socket on other values. */
const [SECRET, NAME] = [/^[\x21-\x7e]{1,300}$/, /^.{1,40}$/u];

let client: Client | null = null;
let address: { url: string; token: string; pupil: string } | null = null;
let resume: string | null = null;
let leaseId: string | null = null;
let tries = 0;
let nextTry: ReturnType<typeof setTimeout> | undefined;
let wordAt = 0;
let probedAt: number | null = null;

export const notified = new Set<(...told: Told) => void>();

/** Address of a station's API from what a user types; null if it is not an address. */
export function apiUrl(text: string): string | null {
  let url: URL;
  try {
    url = new URL(/^[a-z]+:\/\//i.test(text) ? text : `http://${text}`);
  } catch {
    return null;
  }
  const secure = url.protocol === "https:" || url.protocol === "wss:";
  if (!secure && url.protocol !== "http:" && url.protocol !== "ws:") return null;
  return `${secure ? "wss" : "ws"}://${url.host}/api/v1/ws`;
}

/** Connects with a token, or as a pupil of a class with the pupil's code. */
export function connect(url: string, token: string, pupil = ""): void {
  disconnect();
  address = { url, token, pupil };
  keepAccess(token, pupil);
  resume = rememberedAs("sessionStorage", RESUME, SECRET);
  remember("sessionStorage", RESUME, null);
  const isSim = url.startsWith(SIM);
  used.value = isSim ? "sim" : "none";
  store.backend.value = isSim ? "sim" : url.startsWith(SERIAL) ? "serial" : "station";
  open();
}

function keepAccess(token: string, pupil: string): void {
  remember("sessionStorage", TOKEN, token || null);
  remember("sessionStorage", PUPIL, pupil || null);
}

/** Forgets the identity of this page, so that the next user of a shared tablet signs in. */
export function signOut(): void {
  const url = address?.url ?? apiUrl(location.origin);
  store.signInFault.value = null;
  if (url !== null) connect(url, "");
}

/**
 * After this page has made a class: signs in with its PIN, unless the page has its own token,
 * so that it remains the teacher's page.
 */
export function keepTeaching(pin: string | null): void {
  if (address !== null && pin !== null && !address.token && !address.pupil) connect(address.url, pin);
}

/** Connects again: the page takes back a session that another page took over. */
export function again(): void {
  if (address !== null) connect(address.url, address.token, address.pupil);
}

/**
 * Connects to a real arm at a port that the user chooses. While an arm is lost, chooses the port
 * where it is now.
 */
export async function connectSerial(): Promise<void> {
  store.portFault.value = null;
  let chosen: string | null;
  try {
    chosen = await choose();
  } catch (error) {
    return portFails("denied", String((error as Error).message));
  }
  // Choosing no port is not a fault.
  if (chosen === null) return;
  const url = SERIAL + chosen;
  if (store.backend.value === "serial" && store.socket.value === "up") client?.tell({ kind: "port", url });
  else connect(url, "");
}

function portFails(why: NonNullable<typeof store.portFault.value>, more = ""): void {
  store.portFault.value = why;
  log(`${t(`serial.${why}`)} ${more}`.trim());
}

/** Connects to the virtual arm of the page. */
export const connectSim = (): void => connect(`${SIM}${store.simSpeed}`, "");

export const keptToken = (): string => rememberedAs("sessionStorage", TOKEN, SECRET) ?? "";
export const keptPupil = (): string => rememberedAs("sessionStorage", PUPIL, NAME) ?? "";

export function disconnect(): void {
  clearTimeout(nextTry);
  client?.close();
  address = null;
  used.value = "none";
  tries = 0;
  batch(() => {
    store.backend.value = "none";
    store.socket.value = "closed";
    store.refused.value = null;
    store.portFault.value = null;
    store.since.value = null;
    store.pupil.value = null;
    forget();
    store.arms.value = [];
    store.armName.value = null;
  });
}

function forget(): void {
  store.subscription.value = null;
  leaseId = null;
  batch(() => {
    store.state.value = null;
    store.stale.value = true;
    store.session.value = null;
    store.alarms.value = [];
    store.asked.value = null;
    store.asking.value = false;
    store.jobState.value = "none";
    store.model.value = null;
    store.fence.value = null;
  });
}

function open(): void {
  if (address === null) return;
  clearTimeout(nextTry);
  // A port stays open under another session; `close` would stop its arm.
  if (store.backend.value === "serial") client?.fail();
  else client?.close();
  client ??= made();
  if (store.socket.value !== "lost") store.socket.value = "connecting";
  probedAt = null;
  wordAt = performance.now();
  client.tell({ kind: "open", url: address.url });
}

/** The worker is kept during reconnections, since its script may come from the lost station. */
function made(): Client {
  const worker = new Worker(new URL("./worker.ts", import.meta.url), { type: "module" });
  const client = new Client(worker);
  client.onOpened = () => void hello(client);
  client.onNotification = hear;
  client.onWord = () => {
    wordAt = performance.now();
    probedAt = null;
  };
  client.onClosed = lost;
  return client;
}

async function hello(made: Client): Promise<void> {
  const { token, pupil } = address ?? { token: "", pupil: "" };
  const name = ownName.value || t("settings.usualName");
  try {
    const answer = await made.call("session.hello", {
      client: { name, version: "studio" },
      ...(pupil ? { pupil: { name: pupil, code: token } } : isPin(token) ? { pin: token } : token ? { token } : {}),
      ...(resume ? { resume } : {}),
    });
    const { arms } = await made.call("arm.list", {});
    const wasLost = store.socket.value === "lost";
    batch(() => {
      resume = answer.resume;
      tries = 0;
      clearTimeout(nextTry);
      store.refused.value = null;
      if (pupil || token) store.signInFault.value = null;
      store.session.value = answer.session;
      store.hub.value = "hub" in answer;
      store.role.value = answer.role as typeof store.role.value;
      store.ownerName.value = pupil || name;
      store.pupil.value = pupil || null;
      store.arms.value = arms;
      store.since.value = null;
      store.socket.value = "up";
      const names = arms.map((arm) => arm.name);
      const shown = store.armName.value ?? lastArm.value;
      store.armName.value = names.includes(shown) ? shown : (names[0] ?? null);
    });
    const isSim = store.backend.value === "sim";
    const isSerial = store.backend.value === "serial";
    log(
      t(wasLost ? "log.found" : "log.connected", {
        url: isSim ? t("connect.sim") : isSerial ? t("connect.serial") : (address?.url ?? ""),
      }),
    );
    await watch();
    // In the page's own station no other user could grant control.
    if (isSim && store.lease.value === "free") await takeControl();
  } catch (error) {
    // The handler of the closed connection reports why.
    if (!(error instanceof RpcError) || error.code === LINE_ENDED) return;
    log(error.message);
    const of = pupil ? "pupil" : isPin(token) ? "pin" : null;
    if (of !== null) store.signInFault.value = { of, wait: error.data.wait_s, machines: error.data.machines };
  }
}

/** Shows an arm: subscribes to its state and reads its model and last job. */
async function watch(): Promise<void> {
  const arm = store.armName.value;
  if (arm === null || client === null) return;
  const before = store.subscription.value;
  store.subscription.value = null;
  leaseId = null;
  if (before !== null) void client.call("arm.unsubscribe", { subscription: before }).catch(() => {});
  const made = await client.call("arm.subscribe", { arm, rate: RATE });
  store.subscription.value = made.subscription;
  const [{ jobs }] = await Promise.all([client.call("job.list", { arm }), look(arm)]);
  const last = jobs[jobs.length - 1] as Job | undefined;
  store.jobState.value = last?.state ?? "none";
}

/** Reads what rarely changes: the arm's model and its fence. */
async function look(arm: string): Promise<void> {
  if (client === null) return;
  try {
    const [model, { fence }] = await Promise.all([
      client.call("arm.model", { arm }),
      client.call("arm.fence", { arm }),
    ]);
    if (store.armName.value !== arm) return;
    store.model.value = model;
    store.fence.value = fence as store.Fence;
  } catch {
    // The line is lost. They are read again after the reconnection.
  }
}

export function lookAgain(): void {
  if (store.armName.value !== null) void look(store.armName.value);
}

export function show(arm: string): void {
  if (arm === store.armName.value) return;
  batch(() => {
    store.armName.value = arm;
    lastArm.value = arm;
    store.state.value = null;
    store.stale.value = true;
    store.alarms.value = [];
    store.model.value = null;
    store.fence.value = null;
  });
  void watch().catch(() => {});
}

function lost(code: number): void {
  if (address === null) return;
  if (store.backend.value === "sim") {
    disconnect();
    return store.say(t("connect.sim.failed"), true);
  }
  if (store.backend.value === "serial") return lostPort(code);
  client?.close();
  // The worker's script could not be loaded.
  if (code === NO_WORKER) client = null;
  store.subscription.value = null;
  const final = { 4401: "token", 4403: "revoked", 4409: "taken", 4503: "full" } as const;
  const refused = final[code as keyof typeof final] ?? null;
  const wasIn = store.socket.value === "up" || store.socket.value === "lost";
  // A wrong name, code or PIN is not retried and costs nothing: the page goes on as a viewer.
  if (refused === "token" && !wasIn && address.token && store.signInFault.value !== null)
    return connect(address.url, "");
  batch(() => {
    store.asking.value = false;
    store.asked.value = null;
    if (refused !== null) {
      store.refused.value = refused;
      store.socket.value = "closed";
      store.since.value = wasIn ? new Date() : null;
      forget();
      if (refused === "full") nextTry = setTimeout(open, FULL_AGAIN * (1 + Math.random() / 2));
    } else {
      const wasUp = store.socket.value === "up";
      if (wasUp) {
        store.since.value = new Date();
        log(t("log.lost"));
      }
      if (wasUp || store.socket.value === "lost") store.socket.value = "lost";
      else store.refused.value = "unreachable";
      nextTry = setTimeout(open, PAUSES[Math.min(tries++, PAUSES.length - 1)]);
    }
  });
}

/** The worker with the arm's driver reports that there is no arm, or has become silent. */
function lostPort(code: number): void {
  const faults = { [PORT_BUSY]: "busy", [PORT_GONE]: "gone", [PORT_SILENT]: "silent" } as const;
  const why = faults[code as keyof typeof faults];
  // Another port was chosen to replace the lost one and failed. The lost one is still searched for.
  if (why !== undefined && store.socket.value === "up") return portFails(why);
  if (why === undefined && code === 1006 && store.socket.value === "up") {
    // A worker that hangs continues with the same station when it wakes up. Messages to it wait
    // until then.
    client?.fail();
    batch(() => {
      store.subscription.value = null;
      store.since.value = new Date();
      store.socket.value = "lost";
    });
    log(t("log.lost"));
    client?.tell({ kind: "open", url: address?.url ?? "" });
    nextTry = setTimeout(() => lostPort(NO_WORKER), DEAD);
    return;
  }
  if (why === undefined) {
    // A silent worker is terminated. The arm finishes its queue, since nothing else can reach it.
    client?.abandon();
    client = null;
  }
  disconnect();
  portFails(why ?? "died");
  store.say(t(`serial.${why ?? "died"}`), true);
}

function hear(method: string, params: Record<string, unknown>): void {
  const ofShown = params.arm === store.armName.value;
  if (method === "arm.state") {
    if (params.subscription === store.subscription.value) take(params.state as Partial<State>);
  } else if (method === "lease.changed") {
    const holder = params.holder as Holder | null;
    store.arms.value = store.arms.value.map((arm) => (arm.name === params.arm ? { ...arm, holder } : arm));
    if (ofShown && holder?.session !== store.session.value) {
      leaseId = null;
      store.asked.value = null;
    }
    const name = holder === null ? t("lease.nobody") : holder.name;
    log(t("log.holder", { arm: String(params.arm), name }));
  } else if (method === "lease.asked") {
    if (ofShown) store.asked.value = params as unknown as Holder & { message?: string };
  } else if (method === "job.changed") {
    const job = params.job as Job;
    if (job.arm === store.armName.value) store.jobState.value = job.state;
  } else if (method === "arm.event") {
    told(params);
  } else if (method === "session.changed") {
    // A class that begins or ends changes this page's role.
    const own = (params.sessions as { session: string; role: string }[]).find(
      (one) => one.session === store.session.value,
    );
    if (own !== undefined) store.role.value = own.role as typeof store.role.value;
  } else if (method === "server.ending") {
    store.say(t("link.ending"), true);
  }
  for (const listener of notified) (listener as (method: string, params: unknown) => void)(method, params);
}

function told(event: Record<string, unknown>): void {
  const kind = String(event.event);
  if (kind === "lease" || kind === "job" || kind === "command-finished") return;
  const code = event.code;
  const known =
    code === store.SWITCHED_ON ? t("alarms.on") : store.alarms.value.find((alarm) => alarm.code === code)?.name;
  const more = [code === undefined ? null : (known ?? `0x${Number(code).toString(16)}`), event.axis, event.why];
  log([kind, ...more.filter((part) => typeof part === "string")].join(" "));
}

function take(change: Partial<State>): void {
  const before = store.state.value;
  // The state of a resting arm is not rendered again: only the time of the last message has
  // changed.
  if (before !== null && Object.keys(change).every((name) => name === "t")) {
    store.heardAt.value = performance.now();
    if (before.link === "up") store.stale.value = false;
    return;
  }
  const after = { ...before, ...change } as State;
  batch(() => {
    if (change.link !== undefined && change.link !== before?.link) {
      store.since.value = change.link === "lost" ? new Date() : null;
      if (before !== null && change.link === "up") lookAgain();
    }
    store.state.value = after;
    store.heardAt.value = performance.now();
    if (after.link === "up") store.stale.value = false;
    if (change.holder !== undefined) {
      store.arms.value = store.arms.value.map((arm) => {
        return arm.name === after.arm ? { ...arm, holder: after.holder, link: after.link } : arm;
      });
    }
  });
  if (change.alarms !== undefined) void nameAlarms(after.arm, after.alarms ?? []);
  if (change.tool !== undefined && before !== null && String(change.tool.bias) !== String(before.tool.bias))
    lookAgain();
}

async function nameAlarms(arm: string, codes: number[]): Promise<void> {
  if (codes.length === 0) {
    store.alarms.value = [];
    return;
  }
  try {
    const { alarms } = await call("arm.alarms", { arm });
    if (store.armName.value === arm) store.alarms.value = alarms ?? [];
  } catch {
    // The next change of the alarms triggers another request.
  }
}

export function call<M extends Method>(method: M, params: Params<M>): Promise<Result<M>> {
  // A client that is reconnecting would lose the request.
  if (client === null || store.socket.value !== "up") return Promise.reject(new RpcError(LINE_ENDED, t("why.lost")));
  return client.call(method, params);
}

/** True if the bytes between driver and arm can be recorded: the driver runs in this page. */
export const canTrace = (): boolean => store.backend.value === "sim" || store.backend.value === "serial";
export const trace = (): Promise<Uint8Array<ArrayBuffer>> =>
  client?.trace() ?? Promise.reject(new RpcError(LINE_ENDED, t("why.lost")));

/** URL and headers for file transfer by HTTP; null without a server. */
export function files(): { url: string; headers: Record<string, string> } | null {
  if (address === null || store.backend.value !== "station") return null;
  const { protocol, host } = new URL(address.url);
  const headers: Record<string, string> =
    address.token && !address.pupil ? { authorization: `Bearer ${address.token}` } : {};
  return { url: `${protocol === "wss:" ? "https" : "http"}://${host}/api/v1/programs/`, headers };
}

/** Writes a program to the page's own station, or reads it; null if the station is a server's. */
export function ownFile(): ((name: string, bytes?: ArrayBuffer) => Promise<ArrayBuffer>) | null {
  const own = canTrace() && store.socket.value === "up" ? client : null;
  return own && ((name, bytes) => own.file(name, bytes));
}

/** Shown arm as a parameter of calls. */
export const shown = (): { arm: string } => ({ arm: store.armName.value ?? "" });

export const line = {
  jog: (params: Params<"jog.start">, every: number, most: number) =>
    client?.jog(params, every, most) ?? Promise.reject(new RpcError(LINE_ENDED, t("why.lost"))),
  release: () => client?.tell({ kind: "release" }),
  alive: () => client?.tell({ kind: "alive" }),
};

export async function takeControl(): Promise<void> {
  const method = store.lease.value === "other" ? "lease.take" : "lease.acquire";
  leaseId = (await call(method, shown())).lease;
}

export async function giveBack(): Promise<void> {
  // Acquiring a lease again returns its id to the holder: after a reload or a grant the page does
  // not know it.
  const lease = leaseId ?? (await call("lease.acquire", shown())).lease;
  leaseId = null;
  await call("lease.release", { lease });
}

/** Applies a new name by a reconnection: the station resumes the session with the same secret. */
export function rename(): void {
  if (store.socket.value === "up") open();
}

/** `rename` that resolves after the session has resumed. */
export async function renamed(): Promise<void> {
  rename();
  await until(() => store.socket.value !== "connecting" && store.socket.value !== "lost");
}

setInterval(() => {
  const now = performance.now();
  if (now - store.heardAt.value > STALE) store.stale.value = true;
  // A virtual arm in the worker has no line that could be lost.
  if (store.socket.value !== "up" || client === null || store.backend.value === "sim") return;
  const limit = store.backend.value === "serial" && client.computes ? CHECKING : SILENT;
  if (probedAt !== null && now - probedAt > limit) {
    lost(1006);
  } else if (probedAt === null && now - wordAt > SILENT) {
    probedAt = now;
    client.call("server.info", {}).catch(() => {});
  }
}, 250);

/**
 * Releases the connection while the page is hidden. `wake` resumes the same session if the station
 * still has it.
 */
export function rest(): void {
  client?.close();
  store.subscription.value = null;
  store.socket.value = "connecting";
}
export const wake = (): void => open();

document.addEventListener("visibilitychange", () => {
  // After a sleep the next try may be seconds away.
  if (
    !document.hidden &&
    store.backend.value !== "serial" &&
    (store.socket.value === "lost" || store.refused.value === "unreachable")
  )
    open();
});
/**
 * Time for the worker's last message when the page closes, ms. Browsers terminate page and worker
 * together, so the page blocks for this long.
 */
const LAST = 80;
function last(order: ToWorker): void {
  client?.tell(order);
  for (const ends = performance.now() + LAST; performance.now() < ends; );
}
/** Last message of a closing page to its station. */
export const leaveWith = (message: Wire) => last({ kind: "send", message: { jsonrpc: "2.0", ...message } });
addEventListener("pagehide", () => {
  if (store.backend.value === "serial") {
    last({ kind: "leave" });
    // A page restored from the history starts anew.
    disconnect();
  }
  if (resume !== null) remember("sessionStorage", RESUME, resume);
});
