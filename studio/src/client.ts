// The one client of a station's methods: over a worker, which has a WebSocket or the station itself.
import type { Methods, Notifications } from "./api";
import { type FromWorker, NO_WORKER, type ToWorker, type Wire } from "./carrier";
import { jumped } from "./clock";

export type Method = keyof Methods;
export type Params<M extends Method> = Methods[M]["params"];
export type Result<M extends Method> = Methods[M]["result"];
/** What a station tells by itself: which notification, and its parameters. */
export type Told = { [N in keyof Notifications]: [method: N, params: Notifications[N]] }[keyof Notifications];

/** An error that the station answered, or that the line made of a request. */
export class RpcError extends Error {
  constructor(
    readonly code: number,
    message: string,
    readonly data: Record<string, unknown> = {},
  ) {
    super(message);
  }
}

/** The codes of the page's own: the line ended before the answer. */
export const LINE_ENDED = 1;

/** What a station in the worker computes for, and hears nothing meanwhile. */
const COMPUTED: readonly Method[] = ["job.check", "job.start", "job.resume", "program.convert"];

interface Waiting {
  method: Method;
  done: (value: never) => void;
  failed: (error: RpcError) => void;
}

export class Client {
  onNotification: (method: string, params: Record<string, unknown>) => void = () => {};
  onOpened: () => void = () => {};
  onClosed: (code: number) => void = () => {};
  /** Anything came: the other end is alive. */
  onWord: () => void = () => {};
  private onTraced: (file: Uint8Array<ArrayBuffer>) => void = () => {};
  private next = 1;
  private readonly waiting = new Map<number, Waiting>();

  constructor(private readonly worker: Worker) {
    worker.onmessage = (event: MessageEvent<FromWorker>) => this.heard(event.data);
    worker.onerror = () => this.heard({ kind: "closed", code: NO_WORKER });
  }

  tell(message: ToWorker): void {
    this.worker.postMessage(message);
  }

  call<M extends Method>(method: M, params: Params<M>): Promise<Result<M>> {
    const [message, answer] = this.request(method, params);
    this.tell({ kind: "send", message });
    return answer;
  }

  /** Starts a jog that the carrier keeps up until `release`. */
  jog(params: Params<"jog.start">, every: number, most: number): Promise<Result<"jog.start">> {
    const [message, answer] = this.request("jog.start", params);
    this.tell({ kind: "jog", message, every, most });
    return answer;
  }

  /** Keeps a program of the virtual arm's library, or without bytes gets it: past the messages. */
  file(name: string, bytes?: ArrayBuffer): Promise<ArrayBuffer> {
    const [{ id }, answer] = this.request("program.get", { name });
    this.tell({ kind: "file", id, name, ...(bytes ? { bytes } : {}) });
    return answer as Promise<unknown> as Promise<ArrayBuffer>;
  }

  /** What passed between the driver in the worker and its arm, as a trace file. */
  trace(): Promise<Uint8Array<ArrayBuffer>> {
    this.tell({ kind: "trace" });
    return new Promise((done) => (this.onTraced = done));
  }

  /** Nothing comes of what is asked, and of the worker. */
  abandon(): void {
    this.fail();
    this.worker.terminate();
  }

  /** Ends the connection; `open` makes another one. */
  close(): void {
    this.fail();
    this.tell({ kind: "close" });
  }

  private request<M extends Method>(method: M, params: Params<M>): [Wire & { id: number }, Promise<Result<M>>] {
    const id = this.next++;
    const message = { jsonrpc: "2.0" as const, id, method, params };
    const answer = new Promise<Result<M>>((done, failed) => {
      this.waiting.set(id, { method, done: done as (value: never) => void, failed });
    });
    return [message, answer];
  }

  /** Whether it may be silent because it computes. */
  get computes(): boolean {
    return [...this.waiting.values()].some(({ method }) => COMPUTED.includes(method));
  }

  private heard(event: FromWorker): void {
    this.onWord();
    if (event.kind === "opened") return this.onOpened();
    if (event.kind === "closed") {
      this.fail();
      return this.onClosed(event.code);
    }
    if (event.kind === "traced") return this.onTraced(event.file);
    if (event.kind === "jumped") return jumped(event.from, event.ahead);
    const { id, method, params, result, error } = event.message;
    if (method !== undefined) return this.onNotification(method, params ?? {});
    const waiting = this.waiting.get(id ?? -1);
    if (waiting === undefined) return;
    this.waiting.delete(id ?? -1);
    if (error) waiting.failed(new RpcError(error.code, error.message, error.data));
    else waiting.done(result as never);
  }

  /** What waits for an answer gets none. */
  fail(): void {
    for (const { failed } of this.waiting.values()) failed(new RpcError(LINE_ENDED, "the connection ended"));
    this.waiting.clear();
  }
}
