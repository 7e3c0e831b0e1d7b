// How the page and a station exchange messages. The station is behind a worker in every case: one that holds a WebSocket,
// or one in which the station itself runs. Both speak these messages, so the page has one client for all.

/** A message of JSON-RPC, either way. */
export interface Wire {
  jsonrpc?: "2.0";
  id?: number | null;
  method?: string;
  params?: Record<string, unknown>;
  result?: unknown;
  error?: { code: number; message: string; data?: Record<string, unknown> };
}

/** What the page tells the worker. */
export type ToWorker =
  /** A station: its address, or `SIM` and the virtual arm's speed. */
  | { kind: "open"; url: string }
  | { kind: "send"; message: Wire }
  /** Starts a jog, and keeps it up until `release`: `every` and `most` in ms, by the clock of the worker. */
  | { kind: "jog"; message: Wire; every: number; most: number }
  | { kind: "release" }
  /** The page's main thread is alive: a jog is not kept up for a page that hangs. */
  | { kind: "alive" }
  /** With a port: another client of the virtual arm's station. */
  | { kind: "join" }
  /** A program of the virtual arm's library, which is kept, or without bytes given: what a message has no room for. Answered as a request. */
  | { kind: "file"; id: number; name: string; bytes?: ArrayBuffer }
  | { kind: "close" };

/** What the address of a virtual arm in the worker begins with. */
export const SIM = "sim:";

/** What the worker tells the page. */
export type FromWorker =
  | { kind: "opened" }
  | { kind: "heard"; message: Wire }
  | { kind: "closed"; code: number };

export interface Carrier {
  tell(message: ToWorker): void;
  heard: (message: FromWorker) => void;
}

/** The code of `closed` where the worker itself could not be started. */
export const NO_WORKER = 0;

/** A worker, or anything with its two ends, as a carrier. */
export class WorkerCarrier implements Carrier {
  heard: (message: FromWorker) => void = () => {};

  constructor(private readonly worker: Worker) {
    worker.onmessage = (event: MessageEvent<FromWorker>) => this.heard(event.data);
    worker.onerror = () => this.heard({ kind: "closed", code: NO_WORKER });
  }

  tell(message: ToWorker): void {
    this.worker.postMessage(message);
  }
}
