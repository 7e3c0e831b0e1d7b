// Station in the worker: arm.wasm with a virtual arm or with a line to a real one, driven by the
// worker's clock.
import { load, type Station } from "../../crates/magician-wasm/node/shim.mjs";
import { PORT_SILENT, type Wire } from "./carrier";
import { FilesWorker } from "./files";
import { Kept } from "./kept";
import type { SerialLine } from "./serial";

/** Client of a session: receives its messages, and its end with a WebSocket close code. */
export interface Hearer {
  heard(message: Wire): void;
  closed(code: number): void;
}

/** Largest session number: the module's are two bytes long. */
const SESSIONS = 65535;
/** Session of the worker itself, unknown to the page. Prepares the arm and fills the library. */
const OWN = 1;
/** Id of the request that homes an arm after a scenario is loaded. Pages use no negative ids. */
const HOMED = -1;
/** Time for a virtual arm to be ready, homing included, ms on its clock. */
const READY = 120_000;
/** Time for a real arm to answer, ms. The driver's own timeout is three seconds. */
const ANSWERS = 15_000;
/**
 * Delay of a turn from which on the browser or the computer must have slept, ms. A choice: a busy
 * worker is late by less.
 */
const SLEPT = 500;
/** Time for an arm to answer the stop when its page closes, ms. */
const LEAVES = 250;

/** Unix time at zero of the worker's clock, s. */
const unixZero = () => (Date.now() - performance.now()) / 1000;

export class WorkerStation {
  private readonly hearers = new Map<number, Hearer>();
  private last = OWN;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private answers: Wire[] = [];
  private ids = 0;
  private readonly files: FilesWorker;

  private traced: ((file: Uint8Array) => void) | null = null;
  /** True after the page took control: the arm's motion is then the page's. */
  private hasControlled = false;
  /** Session and id of the request that loads a scenario. */
  private loads: { session: number; id: Wire["id"] } | null = null;

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
    private readonly jumped: (from: number, ahead: number) => void,
    private readonly kept: Kept,
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
      this.turns();
    });
  }

  /**
   * Loads the module and homes its virtual arm. The arm's clock is advanced, so that homing costs
   * the user no time.
   */
  static async simulated(module: URL, speed: number, jumped: WorkerStation["jumped"]): Promise<WorkerStation> {
    const first = await fetched(new URL("first.json", module));
    const { scenario } = (await first.json()) as { scenario: string };
    const made = await WorkerStation.load(module, { name: "arm", sim: { speed, scenario } }, null, jumped);
    await made.ready();
    await made.readies();
    return made.opened();
  }

  /**
   * Opens a station at a serial line. Unlike for a virtual arm, the preparation only reads. Throws
   * the code of `closed`.
   */
  static async atLine(module: URL, line: SerialLine): Promise<WorkerStation> {
    const made = await WorkerStation.load(module, { name: "arm", line: true }, line);
    line.begin({
      heard: (bytes) => {
        made.station.lineIn(bytes);
        made.turns();
      },
      is: (there) => {
        made.station.lineIs(there);
        made.turns();
      },
    });
    try {
      await made.ready();
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
    jumped: WorkerStation["jumped"] = () => {},
  ): Promise<WorkerStation> {
    const [code, kept] = await Promise.all([fetched(module), Kept.open()]);
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
    made.hearers.set(OWN, { heard: (message) => made.answers.push(message), closed: () => {} });
    return made;
  }

  private async opened(): Promise<WorkerStation> {
    await this.fills();
    this.turns();
    return this;
  }

  /** Trace file of the recent traffic between driver and arm. */
  trace(): Promise<Uint8Array> {
    return new Promise((done) => {
      this.traced = done;
      this.station.rpc(0, "trace");
      this.turns();
    });
  }

  choosePort(chosen: string): Promise<void> {
    return this.line?.again(chosen) ?? Promise.resolve();
  }

  /**
   * Stops what the page has started on a real arm, ahead of all queued messages, then releases the
   * port.
   */
  async leave(): Promise<void> {
    if (this.line === null) return;
    this.halt();
    await this.until(() => this.answers.find((message) => message.id === this.ids), LEAVES).catch(() => {});
    clearTimeout(this.timer);
    await this.line.close();
  }

  private halt(): void {
    if (!this.hasControlled) return;
    this.answers = [];
    this.hearers.set(OWN, { heard: (message) => this.answers.push(message), closed: () => {} });
    this.own({ method: "arm.stop", params: {} });
    this.turns();
  }

  /** Opens a session. Messages to it go through `send`. */
  connect(hearer: Hearer): number {
    do this.last = (this.last % SESSIONS) + 1;
    while (this.hearers.has(this.last));
    this.hearers.set(this.last, hearer);
    return this.last;
  }

  send(session: number, message: Wire): void {
    if (message.method?.startsWith("lease.")) this.hasControlled = true;
    this.kept.asked(session, message);
    if (message.method === "world.scenario" && this.line === null) this.loads = { session, id: message.id };
    this.station.rpc(session, JSON.stringify(message));
    this.turns();
  }

  end(session: number): void {
    if (!this.hearers.delete(session)) return;
    this.station.rpc(session, "");
    this.turns();
  }

  /** Writes a program to the library, or reads it without `bytes`. */
  file(name: string, bytes?: ArrayBuffer): ArrayBuffer {
    if (bytes === undefined) {
      const found = this.station.programOut(name);
      if (found === null) throw new Error(`${name} is not there`);
      return found.buffer as ArrayBuffer;
    }
    const whole = new Uint8Array(bytes);
    this.keeps(name, whole);
    this.kept.write(name, whole);
    return new ArrayBuffer(0);
  }

  private keeps(name: string, bytes: Uint8Array): void {
    const why = this.station.programIn(name, bytes);
    if (why !== null) throw new Error(new TextDecoder().decode(why));
  }

  private turns(): void {
    clearTimeout(this.timer);
    this.wakes();
    const next = this.turn();
    this.due = next < 0 ? null : Math.max(next - this.clock.ahead, performance.now());
    if (this.due !== null) this.timer = setTimeout(() => this.turns(), this.due - performance.now());
  }

  /**
   * After a sleep of the worker the virtual arm's clock continues where it stopped: missed time is
   * not caught up, so a jog that was held does not run on.
   */
  private wakes(): void {
    const late = this.due === null ? 0 : performance.now() - this.due;
    if (this.line !== null || late < SLEPT) return;
    this.clock.ahead -= late;
    this.tellsAhead();
  }

  private tellsAhead(): void {
    const { ahead } = this.clock;
    this.jumped(unixZero() + (performance.now() + ahead) / 1000, ahead / 1000);
  }

  private turn(): number {
    const next = this.station.turn();
    for (let out = this.station.out(); out !== null; out = this.station.out()) {
      const hearer = this.hearers.get(out.session);
      if (out.kind === "text") {
        const message = JSON.parse(out.payload) as Wire;
        this.kept.answered(out.session, message, (name) => this.station.programOut(name));
        if (out.session === 0 || message.id === HOMED) this.answers.push(message);
        else hearer?.heard(message);
        this.loaded(out.session, message);
      } else if (out.kind === "file") {
        this.files.read(out.payload);
      } else if (out.kind === "close") {
        this.hearers.delete(out.session);
        const [low = 0, high = 0] = out.payload;
        hearer?.closed(low | (high << 8));
      } else if (out.kind === "line") {
        this.line?.say(out.payload);
      } else if (out.kind === "trace") {
        this.traced?.(out.payload);
      }
    }
    return next;
  }

  /**
   * Waits for a value. The clock of a virtual arm is advanced meanwhile; that of a real arm cannot
   * be.
   */
  private async until<T>(found: () => T | undefined, within = this.line === null ? READY : ANSWERS): Promise<T> {
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
      if (this.clock.ahead !== before) this.tellsAhead();
    }
  }

  /** Homes the arm after a scenario is loaded, as at the start, in the session that loaded it. */
  private loaded(session: number, { id, error }: Wire): void {
    if (this.loads === null || session !== this.loads.session || id !== this.loads.id) return;
    this.loads = null;
    if (error) return;
    this.answers = [];
    this.station.rpc(session, JSON.stringify({ jsonrpc: "2.0", id: HOMED, method: "arm.home" }));
    // After the module's current call.
    queueMicrotask(
      () =>
        void this.until(() => this.answers.find((message) => message.id === HOMED))
          .catch(() => {})
          .finally(() => this.turns()),
    );
  }

  private own(message: Wire): void {
    this.station.rpc(OWN, JSON.stringify({ jsonrpc: "2.0", id: ++this.ids, ...message }));
  }

  private async call(method: string, params: Record<string, unknown> = {}): Promise<Record<string, unknown>> {
    this.own({ method, params });
    const answer = await this.until(() => this.answers.find((message) => message.id === this.ids));
    if (answer.error) throw new Error(answer.error.message);
    return answer.result as Record<string, unknown>;
  }

  /** Waits for the module's report that the arm answers. */
  private async ready(): Promise<void> {
    const first = (await this.until(() => this.answers[0])) as unknown as { error?: { kind: string; message: string } };
    if (first.error)
      throw first.error.kind === "timeout" || first.error.kind === "unexpected"
        ? NO_ANSWER
        : new Error(first.error.message);
  }

  private async readies(): Promise<void> {
    await this.call("session.hello", { client: { name: "page" } });
    const { lease } = await this.call("lease.acquire");
    await this.call("arm.clear_alarms");
    await this.call("arm.home");
    await this.call("lease.release", { lease });
    this.answers = [];
  }

  private async fills(): Promise<void> {
    for await (const [name, bytes] of this.kept.all()) this.keeps(name, bytes);
    // Later messages to this session are of no interest.
    this.hearers.set(OWN, { heard: () => {}, closed: () => {} });
  }
}

const NO_ANSWER = new Error("no arm answers");

async function fetched(url: URL): Promise<Response> {
  const answer = await fetch(url);
  if (!answer.ok) throw new Error(`${url.pathname}: ${answer.status}`);
  return answer;
}
