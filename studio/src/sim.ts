// The station in the worker: arm.wasm with a virtual arm, or with a line to a real one, turned by the worker's clock.
import { load, type Station } from "../../crates/magician-wasm/node/shim.mjs";
import { PORT_SILENT, type Wire } from "./carrier";
import { FilesWorker } from "./files";
import { Kept } from "./kept";
import type { SerialLine } from "./serial";

/** What a session hears: its messages, and its end with a code as WebSockets have. */
export interface Hearer {
  heard(message: Wire): void;
  closed(code: number): void;
}

/** Sessions of the module have numbers of two bytes. */
const SESSIONS = 65535;
/** One that the page does not know: it readies the arm, and fills the library. */
const OWN = 1;
/** Id of the request that homes an arm in a new world: no page's own. */
const HOMED = -1;
/** A virtual arm is ready for the page this soon, ms of its clock: homing is over then. */
const READY = 120_000;
/** A real arm has answered by then, ms: the driver asks for three seconds. */
const ANSWERS = 15_000;
/** A turn that is so late, ms, comes after a sleep: of the browser, or of the computer. */
const SLEPT = 500;
/** When a page goes, its arm has so long to answer the stop, ms. */
const LEAVES = 250;

/** Unix seconds when the worker's clock was 0. */
const unixZero = () => (Date.now() - performance.now()) / 1000;

export class WorkerStation {
  private readonly hearers = new Map<number, Hearer>();
  private last = OWN;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private answers: Wire[] = [];
  private ids = 0;
  private readonly files: FilesWorker;

  private traced: ((file: Uint8Array) => void) | null = null;
  /** Control was taken: what moves then is this page's doing. */
  private hasControlled = false;
  /** The request that loads a scenario, by its session. */
  private loads: { session: number; id: Wire["id"] } | null = null;

  /** When the next turn is due, by the worker's clock; null while nothing is. */
  private due: number | null = null;

  private constructor(
    private readonly station: Station,
    /** How far the clock of a virtual arm runs ahead, ms. */
    private readonly clock: { ahead: number },
    /** Hears how far ahead it is, s, from which time on, Unix s by that clock. */
    private readonly jumped: (from: number, ahead: number) => void,
    private readonly kept: Kept,
    private readonly line: SerialLine | null,
    readers: URL,
  ) {
    this.files = new FilesWorker(readers, (id, answer) => {
      try {
        this.station.fileIn(id, answer);
      } catch {
        // There is no memory for it.
        this.station.fileIn(id, new Uint8Array());
      }
      this.turns();
    });
  }

  /** Loads the module and homes its arm: what takes seconds of the arm's clock takes none of the person's. */
  static async simulated(module: URL, speed: number, jumped: WorkerStation["jumped"]): Promise<WorkerStation> {
    const first = await fetched(new URL("first.json", module));
    const { scenario } = (await first.json()) as { scenario: string };
    const made = await WorkerStation.load(module, { name: "arm", sim: { speed, scenario } }, null, jumped);
    await made.ready();
    await made.readies();
    return made.opened();
  }

  /** Over a line: it only reads. `closed` hears of the end; what is thrown is its code. */
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

  /** What passed between the driver and the arm lately, as a file. */
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

  /** Stops what a page has set going on a real arm, before all that waits; then the port is free. */
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

  /** A session of its own; what it is sent goes by `send`. */
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

  /** A program of the library, kept or given. */
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

  /** While the worker slept a virtual arm stood still: it makes up for nothing, and what was held goes no further. */
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

  /** Waits for this: the clock of a virtual arm runs ahead until it is so, that of a real one cannot. */
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

  /** The arm was switched on in the world of a scenario: its session has it homed, as at the start. */
  private loaded(session: number, { id, error }: Wire): void {
    if (this.loads === null || session !== this.loads.session || id !== this.loads.id) return;
    this.loads = null;
    if (error) return;
    this.answers = [];
    this.station.rpc(session, JSON.stringify({ jsonrpc: "2.0", id: HOMED, method: "arm.home" }));
    // Behind what the module is at.
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

  /** The module says whether the arm answers. */
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
    // What it is told from now on nobody reads.
    this.hearers.set(OWN, { heard: () => {}, closed: () => {} });
  }
}

const NO_ANSWER = new Error("no arm answers");

async function fetched(url: URL): Promise<Response> {
  const answer = await fetch(url);
  if (!answer.ok) throw new Error(`${url.pathname}: ${answer.status}`);
  return answer;
}
