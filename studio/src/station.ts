// Station in the worker: arm.wasm with a virtual arm or with a line to a real one, driven by the
// worker's clock.
import { load, type Station } from "../../crates/magician-wasm/node/shim.mjs";
import { FilesWorker } from "./files";
import { StoredLibrary } from "./library";
import { PORT_SILENT, type RpcMessage } from "./messages";
import type { SerialLine } from "./serial";

/** Client of a session: receives its messages, and its end with a WebSocket close code. */
export interface SessionClient {
  onMessage(message: RpcMessage): void;
  onClosed(code: number): void;
}

/** Largest session number: the module's are two bytes long. */
const MAX_SESSION = 65535;
/** Session of the worker itself, unknown to the page. Prepares the arm and fills the library. */
const OWN_SESSION = 1;
/** Id of the request that homes an arm after a scenario is loaded. Pages use no negative ids. */
const HOMING_REQUEST = -1;
/** Time for a virtual arm to be ready, homing included, ms on its clock. */
const READY_TIMEOUT = 120_000;
/** Time for a real arm to answer, ms. The driver's own timeout is three seconds. */
const ANSWER_TIMEOUT = 15_000;
/**
 * Delay of a turn from which on the browser or the computer must have slept, ms. A choice: a busy
 * worker is late by less.
 */
const SLEEP_THRESHOLD = 500;
/** Time for an arm to answer the stop when its page closes, ms. */
const STOP_TIMEOUT = 250;

/** Unix time at zero of the worker's clock, s. */
const unixZero = () => (Date.now() - performance.now()) / 1000;

export class WorkerStation {
  private readonly clients = new Map<number, SessionClient>();
  private lastSession = OWN_SESSION;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private answers: RpcMessage[] = [];
  private lastId = 0;
  private readonly files: FilesWorker;

  private onTrace: ((file: Uint8Array) => void) | null = null;
  /** True after the page took control: the arm's motion is then the page's. */
  private hasControlled = false;
  /** Session and id of the request that loads a scenario. */
  private loadRequest: { session: number; id: RpcMessage["id"] } | null = null;

  /** Time of the next turn, by the worker's clock; null if no turn is due. */
  private due: number | null = null;

  private constructor(
    private readonly station: Station,
    /** Lead of a virtual arm's clock, ms. */
    private readonly clock: { ahead: number },
    /**
     * Called with the time of a jump, Unix s by the virtual arm's clock, and its lead since then,
     * s.
     */
    private readonly onJump: (from: number, ahead: number) => void,
    private readonly kept: StoredLibrary,
    private readonly line: SerialLine | null,
    readers: URL,
  ) {
    this.files = new FilesWorker(readers, (id, answer) => {
      try {
        this.station.fileIn(id, answer);
      } catch {
        // The module has no memory for the answer.
        this.station.fileIn(id, new Uint8Array());
      }
      this.scheduleTurn();
    });
  }

  /**
   * Loads the module and homes its virtual arm. The arm's clock is advanced, so that homing costs
   * the user no time.
   */
  static async simulated(module: URL, speed: number, jumped: WorkerStation["onJump"]): Promise<WorkerStation> {
    const first = await fetchOk(new URL("first.json", module));
    const { scenario } = (await first.json()) as { scenario: string };
    const made = await WorkerStation.load(module, { name: "arm", sim: { speed, scenario } }, null, jumped);
    await made.waitUntilReady();
    await made.prepareArm();
    return made.opened();
  }

  /**
   * Opens a station at a serial line. Unlike for a virtual arm, the preparation only reads. Throws
   * the code of `onClosed`.
   */
  static async atLine(module: URL, line: SerialLine): Promise<WorkerStation> {
    const made = await WorkerStation.load(module, { name: "arm", line: true }, line);
    line.start({
      receive: (bytes) => {
        made.station.lineIn(bytes);
        made.scheduleTurn();
      },
      setPresent: (there) => {
        made.station.lineIs(there);
        made.scheduleTurn();
      },
    });
    try {
      await made.waitUntilReady();
      await made.call("session.hello", { client: { name: "page" } });
    } catch (error) {
      clearTimeout(made.timer);
      await line.close();
      throw error === NO_ANSWER ? PORT_SILENT : error;
    }
    return made.opened();
  }

  private static async load(
    module: URL,
    arm: object,
    line: SerialLine | null,
    jumped: WorkerStation["onJump"] = () => {},
  ): Promise<WorkerStation> {
    const [code, kept] = await Promise.all([fetchOk(module), StoredLibrary.open()]);
    const clock = { ahead: 0 };
    const { open } = await load(await code.arrayBuffer(), () => performance.now() + clock.ahead);
    const epoch = crypto.randomUUID().slice(0, 8);
    const unix_zero = unixZero();
    const made = new WorkerStation(
      open({ arms: [arm], epoch, unix_zero }),
      clock,
      jumped,
      kept,
      line,
      new URL("files.wasm", module),
    );
    made.clients.set(OWN_SESSION, { onMessage: (message) => made.answers.push(message), onClosed: () => {} });
    return made;
  }

  private async opened(): Promise<WorkerStation> {
    await this.fillLibrary();
    this.scheduleTurn();
    return this;
  }

  /** Trace file of the recent traffic between driver and arm. */
  trace(): Promise<Uint8Array> {
    return new Promise((done) => {
      this.onTrace = done;
      this.station.rpc(0, "trace");
      this.scheduleTurn();
    });
  }

  choosePort(chosen: string): Promise<void> {
    return this.line?.reopen(chosen) ?? Promise.resolve();
  }

  /**
   * Stops what the page has started on a real arm, ahead of all queued messages, then releases the
   * port.
   */
  async leave(): Promise<void> {
    if (this.line === null) return;
    this.halt();
    await this.until(() => this.answers.find((message) => message.id === this.lastId), STOP_TIMEOUT).catch(() => {});
    clearTimeout(this.timer);
    await this.line.close();
  }

  private halt(): void {
    if (!this.hasControlled) return;
    this.answers = [];
    this.clients.set(OWN_SESSION, { onMessage: (message) => this.answers.push(message), onClosed: () => {} });
    this.onOwnMessage({ method: "arm.stop", params: {} });
    this.scheduleTurn();
  }

  /** Opens a session. Messages to it go through `send`. */
  connect(hearer: SessionClient): number {
    do this.lastSession = (this.lastSession % MAX_SESSION) + 1;
    while (this.clients.has(this.lastSession));
    this.clients.set(this.lastSession, hearer);
    return this.lastSession;
  }

  send(session: number, message: RpcMessage): void {
    if (message.method?.startsWith("lease.")) this.hasControlled = true;
    this.kept.onRequest(session, message);
    if (message.method === "world.scenario" && this.line === null) this.loadRequest = { session, id: message.id };
    this.station.rpc(session, JSON.stringify(message));
    this.scheduleTurn();
  }

  end(session: number): void {
    if (!this.clients.delete(session)) return;
    this.station.rpc(session, "");
    this.scheduleTurn();
  }

  /** Writes a program to the library, or reads it without `bytes`. */
  file(name: string, bytes?: ArrayBuffer): ArrayBuffer {
    if (bytes === undefined) {
      const found = this.station.programOut(name);
      if (found === null) throw new Error(`${name} is not there`);
      return found.buffer as ArrayBuffer;
    }
    const whole = new Uint8Array(bytes);
    this.storeFile(name, whole);
    this.kept.write(name, whole);
    return new ArrayBuffer(0);
  }

  private storeFile(name: string, bytes: Uint8Array): void {
    const why = this.station.programIn(name, bytes);
    if (why !== null) throw new Error(new TextDecoder().decode(why));
  }

  private scheduleTurn(): void {
    clearTimeout(this.timer);
    this.skipSleep();
    const next = this.turn();
    this.due = next < 0 ? null : Math.max(next - this.clock.ahead, performance.now());
    if (this.due !== null) this.timer = setTimeout(() => this.scheduleTurn(), this.due - performance.now());
  }

  /**
   * After a sleep of the worker the virtual arm's clock continues where it stopped: missed time is
   * not caught up, so a jog that was held does not run on.
   */
  private skipSleep(): void {
    const late = this.due === null ? 0 : performance.now() - this.due;
    if (this.line !== null || late < SLEEP_THRESHOLD) return;
    this.clock.ahead -= late;
    this.reportAhead();
  }

  private reportAhead(): void {
    const { ahead } = this.clock;
    this.onJump(unixZero() + (performance.now() + ahead) / 1000, ahead / 1000);
  }

  private turn(): number {
    const next = this.station.turn();
    for (let out = this.station.out(); out !== null; out = this.station.out()) {
      const hearer = this.clients.get(out.session);
      if (out.kind === "text") {
        const message = JSON.parse(out.payload) as RpcMessage;
        this.kept.onAnswer(out.session, message, (name) => this.station.programOut(name));
        if (out.session === 0 || message.id === HOMING_REQUEST) this.answers.push(message);
        else hearer?.onMessage(message);
        this.loaded(out.session, message);
      } else if (out.kind === "file") {
        this.files.read(out.payload);
      } else if (out.kind === "close") {
        this.clients.delete(out.session);
        const [low = 0, high = 0] = out.payload;
        hearer?.onClosed(low | (high << 8));
      } else if (out.kind === "line") {
        this.line?.write(out.payload);
      } else if (out.kind === "trace") {
        this.onTrace?.(out.payload);
      }
    }
    return next;
  }

  /**
   * Waits for a value. The clock of a virtual arm is advanced meanwhile; that of a real arm cannot
   * be.
   */
  private async until<T>(
    found: () => T | undefined,
    within = this.line === null ? READY_TIMEOUT : ANSWER_TIMEOUT,
  ): Promise<T> {
    const now = () => performance.now() + this.clock.ahead;
    const before = this.clock.ahead;
    try {
      for (const ends = now() + within; now() < ends; ) {
        const next = this.turn();
        const what = found();
        if (what !== undefined) return what;
        const left = Math.max(0, next - now());
        if (this.line === null) this.clock.ahead += left;
        else await new Promise((done) => setTimeout(done, left));
      }
      throw new Error("the arm does not become ready");
    } finally {
      if (this.clock.ahead !== before) this.reportAhead();
    }
  }

  /** Homes the arm after a scenario is loaded, as at the start, in the session that loaded it. */
  private loaded(session: number, { id, error }: RpcMessage): void {
    if (this.loadRequest === null || session !== this.loadRequest.session || id !== this.loadRequest.id) return;
    this.loadRequest = null;
    if (error) return;
    this.answers = [];
    this.station.rpc(session, JSON.stringify({ jsonrpc: "2.0", id: HOMING_REQUEST, method: "arm.home" }));
    // After the module's current call.
    queueMicrotask(
      () =>
        void this.until(() => this.answers.find((message) => message.id === HOMING_REQUEST))
          .catch(() => {})
          .finally(() => this.scheduleTurn()),
    );
  }

  private onOwnMessage(message: RpcMessage): void {
    this.station.rpc(OWN_SESSION, JSON.stringify({ jsonrpc: "2.0", id: ++this.lastId, ...message }));
  }

  private async call(method: string, params: Record<string, unknown> = {}): Promise<Record<string, unknown>> {
    this.onOwnMessage({ method, params });
    const answer = await this.until(() => this.answers.find((message) => message.id === this.lastId));
    if (answer.error) throw new Error(answer.error.message);
    return answer.result as Record<string, unknown>;
  }

  /** Waits for the module's report that the arm answers. */
  private async waitUntilReady(): Promise<void> {
    const first = (await this.until(() => this.answers[0])) as unknown as { error?: { kind: string; message: string } };
    if (first.error)
      throw first.error.kind === "timeout" || first.error.kind === "unexpected"
        ? NO_ANSWER
        : new Error(first.error.message);
  }

  private async prepareArm(): Promise<void> {
    await this.call("session.hello", { client: { name: "page" } });
    const { lease } = await this.call("lease.acquire");
    await this.call("arm.clear_alarms");
    await this.call("arm.home");
    await this.call("lease.release", { lease });
    this.answers = [];
  }

  private async fillLibrary(): Promise<void> {
    for await (const [name, bytes] of this.kept.all()) this.storeFile(name, bytes);
    // Later messages to this session are of no interest.
    this.clients.set(OWN_SESSION, { onMessage: () => {}, onClosed: () => {} });
  }
}

const NO_ANSWER = new Error("no arm answers");

async function fetchOk(url: URL): Promise<Response> {
  const answer = await fetch(url);
  if (!answer.ok) throw new Error(`${url.pathname}: ${answer.status}`);
  return answer;
}
