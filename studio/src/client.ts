// Client for the methods of a station, behind a worker that has a WebSocket or contains the
// station.
import type { Methods, Notifications } from "./api";
import { recordJump } from "./clock";
import { type FromWorker, NO_WORKER, type RpcMessage, type ToWorker } from "./messages";

export type Method = keyof Methods;
export type Params<M extends Method> = Methods[M]["params"];
export type Result<M extends Method> = Methods[M]["result"];
/** Notification of a station with its parameters. */
export type StationNotification = {
  [N in keyof Notifications]: [method: N, params: Notifications[N]];
}[keyof Notifications];

/** Error from the station, or caused by the end of the connection. */
export class RpcError extends Error {
  constructor(
    readonly code: number,
    message: string,
    readonly data: Record<string, unknown> = {},
  ) {
    super(message);
  }
}

/** Code of the page itself: the connection ended before the answer. */
export const CONNECTION_ENDED = 1;

/** Methods during which a station in the worker is busy and answers nothing else. */
const COMPUTING_METHODS: readonly Method[] = [
  "job.check",
  "job.start",
  "job.resume",
  "program.convert",
  "teach.rows",
  "teach.plan",
];

interface PendingRequest {
  method: Method;
  resolve: (value: never) => void;
  reject: (error: RpcError) => void;
}

export class Client {
  onNotification: (method: string, params: Record<string, unknown>) => void = () => {};
  onOpened: () => void = () => {};
  onClosed: (code: number) => void = () => {};
  /** Called for every message: the other end is alive. */
  onMessage: () => void = () => {};
  private onTraced: (file: Uint8Array<ArrayBuffer>) => void = () => {};
  private nextId = 1;
  private readonly pending = new Map<number, PendingRequest>();

  constructor(private readonly worker: Worker) {
    worker.onmessage = (event: MessageEvent<FromWorker>) => this.onWorkerMessage(event.data);
    worker.onerror = () => this.onWorkerMessage({ kind: "closed", code: NO_WORKER });
  }

  post(message: ToWorker): void {
    this.worker.postMessage(message);
  }

  call<M extends Method>(method: M, params: Params<M>): Promise<Result<M>> {
    const [message, answer] = this.request(method, params);
    this.post({ kind: "send", message });
    return answer;
  }

  /** Starts a jog that the worker keeps alive until `release`. */
  jog(params: Params<"jog.start">, every: number, most: number): Promise<Result<"jog.start">> {
    const [message, answer] = this.request("jog.start", params);
    this.post({ kind: "jog", message, every, most });
    return answer;
  }

  /**
   * Writes a program of the virtual arm's library, or reads it without `bytes`. Bypasses the
   * messages.
   */
  file(name: string, bytes?: ArrayBuffer): Promise<ArrayBuffer> {
    const [{ id }, answer] = this.request("program.get", { name });
    this.post({ kind: "file", id, name, ...(bytes ? { bytes } : {}) });
    return answer as Promise<unknown> as Promise<ArrayBuffer>;
  }

  /** Trace file of the traffic between the driver in the worker and its arm. */
  trace(): Promise<Uint8Array<ArrayBuffer>> {
    this.post({ kind: "trace" });
    return new Promise((done) => (this.onTraced = done));
  }

  /** Fails all requests and terminates the worker. */
  abandon(): void {
    this.fail();
    this.worker.terminate();
  }

  /** Ends the connection; `open` starts another one. */
  close(): void {
    this.fail();
    this.post({ kind: "close" });
  }

  private request<M extends Method>(method: M, params: Params<M>): [RpcMessage & { id: number }, Promise<Result<M>>] {
    const id = this.nextId++;
    const message = { jsonrpc: "2.0" as const, id, method, params };
    const answer = new Promise<Result<M>>((done, failed) => {
      this.pending.set(id, { method, resolve: done as (value: never) => void, reject: failed });
    });
    return [message, answer];
  }

  /** True if the station may be silent because it is computing. */
  get isComputing(): boolean {
    return [...this.pending.values()].some(({ method }) => COMPUTING_METHODS.includes(method));
  }

  private onWorkerMessage(event: FromWorker): void {
    this.onMessage();
    if (event.kind === "opened") return this.onOpened();
    if (event.kind === "closed") {
      this.fail();
      return this.onClosed(event.code);
    }
    if (event.kind === "traced") return this.onTraced(event.file);
    if (event.kind === "jumped") return recordJump(event.from, event.ahead);
    const { id, method, params, result, error } = event.message;
    if (method !== undefined) return this.onNotification(method, params ?? {});
    const waiting = this.pending.get(id ?? -1);
    if (waiting === undefined) return;
    this.pending.delete(id ?? -1);
    if (error) waiting.reject(new RpcError(error.code, error.message, error.data));
    else waiting.resolve(result as never);
  }

  /** Fails all pending requests. */
  fail(): void {
    for (const { reject: failed } of this.pending.values())
      failed(new RpcError(CONNECTION_ENDED, "the connection ended"));
    this.pending.clear();
  }
}
