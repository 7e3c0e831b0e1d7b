// Session with a station: connects, keeps it alive, reconnects, and puts notifications into the
// store.
import { batch } from "@preact/signals";
import type { Holder, Job, State } from "./api";
import {
  Client,
  CONNECTION_ENDED,
  type Method,
  type Params,
  type Result,
  RpcError,
  type StationNotification,
} from "./client";
import { t } from "./i18n";
import { log } from "./log";
import { NO_WORKER, PORT_BUSY, PORT_GONE, PORT_SILENT, type RpcMessage, SERIAL, SIM, type ToWorker } from "./messages";
import { isPin } from "./pairing";
import { choosePort } from "./serial";
import { lastArm, lastBackend, ownName, readMatching, writeValue } from "./settings";
import * as store from "./store";
import { until } from "./until";

/** Rate of state notifications, Hz. */
const STATE_RATE = 20;
/** Backoff before a reconnection, ms. The last pause repeats. */
const RECONNECT_DELAYS = [200, 400, 800, 1600, 3200, 5000];
const STALE_AFTER = 1000;
/**
 * Silence after which the station is asked for a message, ms. After the same time without an answer
 * the connection counts as dead.
 */
const SILENCE_TIMEOUT = 1500;
/**
 * The same limit for a station in the worker, ms, which cannot answer while it checks a program.
 */
const CHECK_SILENCE_TIMEOUT = 60_000;
/** Further silence after which a worker with a real arm is terminated, ms. */
const WORKER_TIMEOUT = 8000;
/**
 * Pause before a full station is tried again, ms. Up to half as much is added at random, so that
 * pages refused together do not return together.
 */
const FULL_RETRY_DELAY = 15_000;
const RESUME_KEY = "resume";
/** A token is kept until the tab is closed, since tablets are shared. */
const TOKEN_KEY = "token";
const PUPIL_KEY = "pupil";
/** Patterns of secrets and names. The station closes the socket on other values. */
const [SECRET_PATTERN, NAME_PATTERN] = [/^[\x21-\x7e]{1,300}$/, /^.{1,40}$/u];

let client: Client | null = null;
let address: { url: string; token: string; pupil: string } | null = null;
let resume: string | null = null;
let leaseId: string | null = null;
let attempts = 0;
let retryTimer: ReturnType<typeof setTimeout> | undefined;
let lastMessageAt = 0;
let probedAt: number | null = null;

export const notificationListeners = new Set<(...notification: StationNotification) => void>();

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
  resume = readMatching("sessionStorage", RESUME_KEY, SECRET_PATTERN);
  writeValue("sessionStorage", RESUME_KEY, null);
  const isSim = url.startsWith(SIM);
  lastBackend.value = isSim ? "sim" : "none";
  store.backend.value = isSim ? "sim" : url.startsWith(SERIAL) ? "serial" : "station";
  open();
}

function keepAccess(token: string, pupil: string): void {
  writeValue("sessionStorage", TOKEN_KEY, token || null);
  writeValue("sessionStorage", PUPIL_KEY, pupil || null);
}

/** Forgets the identity of this page, so that the next user of a shared tablet signs in. */
export function signOut(): void {
  const url = address?.url ?? apiUrl(location.origin);
  store.signInFault.value = null;
  if (url !== null) connect(url, "");
}

/**
 * Signs in with the PIN of the class that this page has just created, so that it remains the
 * teacher's page. Does nothing if the page is signed in already.
 */
export function keepTeaching(pin: string | null): void {
  if (address !== null && pin !== null && !address.token && !address.pupil) connect(address.url, pin);
}

/** Connects again: the page takes back a session that another page took over. */
export function takeBackSession(): void {
  if (address !== null) connect(address.url, address.token, address.pupil);
}

/**
 * Connects to a real arm at a port that the user chooses. If the arm is lost, the connection
 * continues at the chosen port.
 */
export async function connectSerial(): Promise<void> {
  store.portFault.value = null;
  let chosen: string | null;
  try {
    chosen = await choosePort();
  } catch (error) {
    return reportPortFault("denied", String((error as Error).message));
  }
  // Choosing no port is not a fault.
  if (chosen === null) return;
  const url = SERIAL + chosen;
  if (store.backend.value === "serial" && store.socket.value === "up") client?.post({ kind: "port", url });
  else connect(url, "");
}

function reportPortFault(why: NonNullable<typeof store.portFault.value>, detail = ""): void {
  store.portFault.value = why;
  log(`${t(`serial.${why}`)} ${detail}`.trim());
}

/** Connects to the virtual arm of the page. */
export const connectSim = (): void => connect(`${SIM}${store.simSpeed}`, "");

export const keptToken = (): string => readMatching("sessionStorage", TOKEN_KEY, SECRET_PATTERN) ?? "";
export const keptPupil = (): string => readMatching("sessionStorage", PUPIL_KEY, NAME_PATTERN) ?? "";

export function disconnect(): void {
  clearTimeout(retryTimer);
  client?.close();
  address = null;
  lastBackend.value = "none";
  attempts = 0;
  batch(() => {
    store.backend.value = "none";
    store.socket.value = "closed";
    store.refused.value = null;
    store.portFault.value = null;
    store.lostSince.value = null;
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
    store.controlRequest.value = null;
    store.isRequestingControl.value = false;
    store.jobState.value = "none";
    store.model.value = null;
    store.fence.value = null;
  });
}

function open(): void {
  if (address === null) return;
  clearTimeout(retryTimer);
  // The port stays open for the next session; `close` would stop the arm.
  if (store.backend.value === "serial") client?.fail();
  else client?.close();
  client ??= ensureClient();
  if (store.socket.value !== "lost") store.socket.value = "connecting";
  probedAt = null;
  lastMessageAt = performance.now();
  client.post({ kind: "open", url: address.url });
}

/** The worker is kept during reconnections, since its script may come from the lost station. */
function ensureClient(): Client {
  const worker = new Worker(new URL("./worker.ts", import.meta.url), { type: "module" });
  const client = new Client(worker);
  client.onOpened = () => void openSession(client);
  client.onNotification = onNotification;
  client.onMessage = () => {
    lastMessageAt = performance.now();
    probedAt = null;
  };
  client.onClosed = onConnectionLost;
  return client;
}

async function openSession(openedClient: Client): Promise<void> {
  const { token, pupil } = address ?? { token: "", pupil: "" };
  const name = ownName.value || t("settings.usualName");
  try {
    const answer = await openedClient.call("session.hello", {
      client: { name, version: "studio" },
      ...(pupil ? { pupil: { name: pupil, code: token } } : isPin(token) ? { pin: token } : token ? { token } : {}),
      ...(resume ? { resume } : {}),
    });
    const { arms } = await openedClient.call("arm.list", {});
    const wasLost = store.socket.value === "lost";
    batch(() => {
      resume = answer.resume;
      attempts = 0;
      clearTimeout(retryTimer);
      store.refused.value = null;
      if (pupil || token) store.signInFault.value = null;
      store.session.value = answer.session;
      store.hub.value = "hub" in answer;
      store.role.value = answer.role as typeof store.role.value;
      store.ownerName.value = pupil || name;
      store.pupil.value = pupil || null;
      store.arms.value = arms;
      store.lostSince.value = null;
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
    await watchArm();
    // The page's own station has no other users, so the page takes control at once.
    if (isSim && store.lease.value === "free") await takeLease();
  } catch (error) {
    // The handler of the closed connection reports why.
    if (!(error instanceof RpcError) || error.code === CONNECTION_ENDED) return;
    log(error.message);
    const of = pupil ? "pupil" : isPin(token) ? "pin" : null;
    if (of !== null) store.signInFault.value = { of, wait: error.data.wait_s, machines: error.data.machines };
  }
}

/** Shows an arm: subscribes to its state and reads its model and last job. */
async function watchArm(): Promise<void> {
  const arm = store.armName.value;
  if (arm === null || client === null) return;
  const before = store.subscription.value;
  store.subscription.value = null;
  leaseId = null;
  if (before !== null) void client.call("arm.unsubscribe", { subscription: before }).catch(() => {});
  const subscribed = await client.call("arm.subscribe", { arm, rate: STATE_RATE });
  store.subscription.value = subscribed.subscription;
  const [{ jobs }] = await Promise.all([client.call("job.list", { arm }), readArm(arm)]);
  const last = jobs[jobs.length - 1] as Job | undefined;
  store.jobState.value = last?.state ?? "none";
}

/** Reads what rarely changes: the arm's model and its fence. */
async function readArm(arm: string): Promise<void> {
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

export function rereadArm(): void {
  if (store.armName.value !== null) void readArm(store.armName.value);
}

export function showArm(arm: string): void {
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
  void watchArm().catch(() => {});
}

function onConnectionLost(code: number): void {
  if (address === null) return;
  if (store.backend.value === "sim") {
    disconnect();
    return store.notify(t("connect.sim.failed"), true);
  }
  if (store.backend.value === "serial") return onPortLost(code);
  client?.close();
  // The worker's script could not be loaded.
  if (code === NO_WORKER) client = null;
  store.subscription.value = null;
  const final = { 4401: "token", 4403: "revoked", 4409: "taken", 4503: "full" } as const;
  const refused = final[code as keyof typeof final] ?? null;
  const wasConnected = store.socket.value === "up" || store.socket.value === "lost";
  // A wrong name, code or PIN is not retried and costs nothing: the page goes on as a viewer.
  if (refused === "token" && !wasConnected && address.token && store.signInFault.value !== null)
    return connect(address.url, "");
  batch(() => {
    store.isRequestingControl.value = false;
    store.controlRequest.value = null;
    if (refused !== null) {
      store.refused.value = refused;
      store.socket.value = "closed";
      store.lostSince.value = wasConnected ? new Date() : null;
      forget();
      if (refused === "full") retryTimer = setTimeout(open, FULL_RETRY_DELAY * (1 + Math.random() / 2));
    } else {
      const wasUp = store.socket.value === "up";
      if (wasUp) {
        store.lostSince.value = new Date();
        log(t("log.lost"));
      }
      if (wasUp || store.socket.value === "lost") store.socket.value = "lost";
      else store.refused.value = "unreachable";
      retryTimer = setTimeout(open, RECONNECT_DELAYS[Math.min(attempts++, RECONNECT_DELAYS.length - 1)]);
    }
  });
}

/** The worker with the arm's driver reports that there is no arm, or has become silent. */
function onPortLost(code: number): void {
  const faults = { [PORT_BUSY]: "busy", [PORT_GONE]: "gone", [PORT_SILENT]: "silent" } as const;
  const why = faults[code as keyof typeof faults];
  // Another port was chosen to replace the lost one and failed. The lost one is still searched for.
  if (why !== undefined && store.socket.value === "up") return reportPortFault(why);
  if (why === undefined && code === 1006 && store.socket.value === "up") {
    // A worker that hangs continues with the same station when it wakes up. Messages to it wait
    // until then.
    client?.fail();
    batch(() => {
      store.subscription.value = null;
      store.lostSince.value = new Date();
      store.socket.value = "lost";
    });
    log(t("log.lost"));
    client?.post({ kind: "open", url: address?.url ?? "" });
    retryTimer = setTimeout(() => onPortLost(NO_WORKER), WORKER_TIMEOUT);
    return;
  }
  if (why === undefined) {
    // A silent worker is terminated. The arm finishes its queue, since nothing else can reach it.
    client?.abandon();
    client = null;
  }
  disconnect();
  reportPortFault(why ?? "died");
  store.notify(t(`serial.${why ?? "died"}`), true);
}

function onNotification(method: string, params: Record<string, unknown>): void {
  const isOfShownArm = params.arm === store.armName.value;
  if (method === "arm.state") {
    if (params.subscription === store.subscription.value) applyState(params.state as Partial<State>);
  } else if (method === "lease.changed") {
    const holder = params.holder as Holder | null;
    store.arms.value = store.arms.value.map((arm) => (arm.name === params.arm ? { ...arm, holder } : arm));
    if (isOfShownArm && holder?.session !== store.session.value) {
      leaseId = null;
      store.controlRequest.value = null;
    }
    const name = holder === null ? t("lease.nobody") : holder.name;
    log(t("log.holder", { arm: String(params.arm), name }));
  } else if (method === "lease.asked") {
    if (isOfShownArm) store.controlRequest.value = params as unknown as Holder & { message?: string };
  } else if (method === "job.changed") {
    const job = params.job as Job;
    if (job.arm === store.armName.value) store.jobState.value = job.state;
  } else if (method === "arm.event") {
    onEvent(params);
  } else if (method === "session.changed") {
    // A class that begins or ends changes this page's role.
    const ownSession = (params.sessions as { session: string; role: string }[]).find(
      (one) => one.session === store.session.value,
    );
    if (ownSession !== undefined) store.role.value = ownSession.role as typeof store.role.value;
  } else if (method === "server.ending") {
    store.notify(t("link.ending"), true);
  }
  for (const listener of notificationListeners) (listener as (method: string, params: unknown) => void)(method, params);
}

function onEvent(event: Record<string, unknown>): void {
  const kind = String(event.event);
  if (kind === "lease" || kind === "job" || kind === "command-finished") return;
  const code = event.code;
  const known =
    code === store.SWITCHED_ON ? t("alarms.on") : store.alarms.value.find((alarm) => alarm.code === code)?.name;
  const details = [code === undefined ? null : (known ?? `0x${Number(code).toString(16)}`), event.axis, event.why];
  log([kind, ...details.filter((part) => typeof part === "string")].join(" "));
}

function applyState(change: Partial<State>): void {
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
      store.lostSince.value = change.link === "lost" ? new Date() : null;
      if (before !== null && change.link === "up") rereadArm();
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
    rereadArm();
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
  if (client === null || store.socket.value !== "up")
    return Promise.reject(new RpcError(CONNECTION_ENDED, t("why.lost")));
  return client.call(method, params);
}

/** True if the bytes between driver and arm can be recorded: the driver runs in this page. */
export const canTrace = (): boolean => store.backend.value === "sim" || store.backend.value === "serial";
export const trace = (): Promise<Uint8Array<ArrayBuffer>> =>
  client?.trace() ?? Promise.reject(new RpcError(CONNECTION_ENDED, t("why.lost")));

/** URL and headers for file transfer by HTTP; null without a server. */
export function fileEndpoint(): { url: string; headers: Record<string, string> } | null {
  if (address === null || store.backend.value !== "station") return null;
  const { protocol, host } = new URL(address.url);
  const headers: Record<string, string> =
    address.token && !address.pupil ? { authorization: `Bearer ${address.token}` } : {};
  return { url: `${protocol === "wss:" ? "https" : "http"}://${host}/api/v1/programs/`, headers };
}

/** Function that writes or reads a program of the page's own station; null for another station. */
export function localFile(): ((name: string, bytes?: ArrayBuffer) => Promise<ArrayBuffer>) | null {
  const localClient = canTrace() && store.socket.value === "up" ? client : null;
  return localClient && ((name, bytes) => localClient.file(name, bytes));
}

/** Shown arm as a parameter of calls. */
export const shownArm = (): { arm: string } => ({ arm: store.armName.value ?? "" });

export const jogLine = {
  jog: (params: Params<"jog.start">, every: number, most: number) =>
    client?.jog(params, every, most) ?? Promise.reject(new RpcError(CONNECTION_ENDED, t("why.lost"))),
  release: () => client?.post({ kind: "release" }),
  alive: () => client?.post({ kind: "alive" }),
};

export async function takeLease(): Promise<void> {
  const method = store.lease.value === "other" ? "lease.take" : "lease.acquire";
  leaseId = (await call(method, shownArm())).lease;
}

export async function releaseLease(): Promise<void> {
  // Acquiring a lease again returns its id to the holder: after a reload or a grant the page does
  // not know it.
  const lease = leaseId ?? (await call("lease.acquire", shownArm())).lease;
  leaseId = null;
  await call("lease.release", { lease });
}

/** Applies a new name by a reconnection: the station resumes the session with the same secret. */
export function applyName(): void {
  if (store.socket.value === "up") open();
}

/** `applyName` that resolves after the session has resumed. */
export async function applyNameAndWait(): Promise<void> {
  applyName();
  await until(() => store.socket.value !== "connecting" && store.socket.value !== "lost");
}

setInterval(() => {
  const now = performance.now();
  if (now - store.heardAt.value > STALE_AFTER) store.stale.value = true;
  // A virtual arm in the worker has no line that could be lost.
  if (store.socket.value !== "up" || client === null || store.backend.value === "sim") return;
  const limit = store.backend.value === "serial" && client.isComputing ? CHECK_SILENCE_TIMEOUT : SILENCE_TIMEOUT;
  if (probedAt !== null && now - probedAt > limit) {
    onConnectionLost(1006);
  } else if (probedAt === null && now - lastMessageAt > SILENCE_TIMEOUT) {
    probedAt = now;
    client.call("server.info", {}).catch(() => {});
  }
}, 250);

/**
 * Releases the connection while the page is hidden. `restoreConnection` resumes the same session if
 * the station still has it.
 */
export function releaseConnection(): void {
  client?.close();
  store.subscription.value = null;
  store.socket.value = "connecting";
}
export const restoreConnection = (): void => open();

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
const LAST_MESSAGE_TIME = 80;
function postLast(message: ToWorker): void {
  client?.post(message);
  for (const deadline = performance.now() + LAST_MESSAGE_TIME; performance.now() < deadline; );
}
/** Last message of a closing page to its station. */
export const sendOnClose = (message: RpcMessage) => postLast({ kind: "send", message: { jsonrpc: "2.0", ...message } });
addEventListener("pagehide", () => {
  if (store.backend.value === "serial") {
    postLast({ kind: "leave" });
    // A page restored from the history starts anew.
    disconnect();
  }
  if (resume !== null) writeValue("sessionStorage", RESUME_KEY, resume);
});
