// The station in the worker: arm.wasm with a virtual arm, turned by the worker's clock.
import { load, type Station } from "../../crates/magician-wasm/node/shim.mjs";
import type { Wire } from "./carrier";
import { FilesWorker } from "./files";
import { Kept } from "./kept";

/** What a session hears: its messages, and its end with a code as WebSockets have. */
export interface Hearer {
  heard(message: Wire): void;
  closed(code: number): void;
}

/** Sessions of the module have numbers of two bytes. */
const SESSIONS = 65535;
/** One that the page does not know: it readies the arm, and fills the library. */
const OWN = 1;
/** A virtual arm is ready for the page this soon, ms of its clock: homing is over then. */
const READY = 120_000;

export class SimStation {
  private readonly hearers = new Map<number, Hearer>();
  private last = OWN;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private answers: Wire[] = [];
  private ids = 0;
  private readonly files: FilesWorker;

  private constructor(
    private readonly station: Station,
    private readonly clock: { ahead: number },
    private readonly kept: Kept,
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
  static async open(module: URL, speed: number): Promise<SimStation> {
    const fetched = async (url: URL) => {
      const answer = await fetch(url);
      if (!answer.ok) throw new Error(`${url.pathname}: ${answer.status}`);
      return answer;
    };
    const [code, first, kept] = await Promise.all([fetched(module), fetched(new URL("first.json", module)), Kept.open()]);
    const { scenario } = (await first.json()) as { scenario: string };
    const clock = { ahead: 0 };
    const now = () => performance.now() + clock.ahead;
    const { open } = await load(await code.arrayBuffer(), now);
    const epoch = crypto.randomUUID().slice(0, 8);
    const unix_zero = (Date.now() - performance.now()) / 1000;
    const station = open({ arms: [{ name: "arm", sim: { speed, scenario } }], epoch, unix_zero });
    const made = new SimStation(station, clock, kept, new URL("files.wasm", module));
    made.hearers.set(OWN, { heard: (message) => made.answers.push(message), closed: () => {} });
    made.readies();
    await made.fills();
    made.turns();
    return made;
  }

  /** A session of its own; what it is sent goes by `send`. */
  connect(hearer: Hearer): number {
    do this.last = (this.last % SESSIONS) + 1;
    while (this.hearers.has(this.last));
    this.hearers.set(this.last, hearer);
    return this.last;
  }

  send(session: number, message: Wire): void {
    this.kept.asked(session, message);
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
    const next = this.turn();
    if (next >= 0) this.timer = setTimeout(() => this.turns(), Math.max(0, next - performance.now() - this.clock.ahead));
  }

  private turn(): number {
    const next = this.station.turn();
    for (let out = this.station.out(); out !== null; out = this.station.out()) {
      const hearer = this.hearers.get(out.session);
      if (out.kind === "text") {
        const message = JSON.parse(out.payload) as Wire;
        this.kept.answered(out.session, message, (name) => this.station.programOut(name));
        if (out.session === 0) this.answers.push(message);
        else hearer?.heard(message);
      } else if (out.kind === "file") {
        this.files.read(out.payload);
      } else if (out.kind === "close") {
        this.hearers.delete(out.session);
        hearer?.closed(out.payload[0]! | (out.payload[1]! << 8));
      }
    }
    return next;
  }

  /** The clock runs ahead until this is so. */
  private until<T>(found: () => T | undefined): T {
    for (const ends = this.clock.ahead + READY; this.clock.ahead < ends; ) {
      const next = this.turn();
      const what = found();
      if (what !== undefined) return what;
      this.clock.ahead += Math.max(0, next - performance.now() - this.clock.ahead);
    }
    throw new Error("the virtual arm does not become ready");
  }

  private call(method: string, params: Record<string, unknown> = {}): Record<string, unknown> {
    this.station.rpc(OWN, JSON.stringify({ jsonrpc: "2.0", id: ++this.ids, method, params }));
    const answer = this.until(() => this.answers.find((message) => message.id === this.ids));
    if (answer.error) throw new Error(answer.error.message);
    return answer.result as Record<string, unknown>;
  }

  private readies(): void {
    const first = this.until(() => this.answers[0]) as { error?: { message: string } };
    if (first.error) throw new Error(first.error.message);
    this.call("session.hello", { client: { name: "page" } });
    const { lease } = this.call("lease.acquire");
    this.call("arm.clear_alarms");
    this.call("arm.home");
    this.call("lease.release", { lease });
    this.answers = [];
  }

  private async fills(): Promise<void> {
    for await (const [name, bytes] of this.kept.all()) this.keeps(name, bytes);
    // What it is told from now on nobody reads.
    this.hearers.set(OWN, { heard: () => {}, closed: () => {} });
  }
}
