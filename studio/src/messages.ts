// Messages between page and worker. The station is always behind a worker, which either holds a
// WebSocket to it or runs the station itself. Both use the same messages, so the page has one
// client for all stations.

/** JSON-RPC message in either direction. */
export interface RpcMessage {
  jsonrpc?: "2.0";
  id?: number | null;
  method?: string;
  params?: Record<string, unknown>;
  result?: unknown;
  error?: { code: number; message: string; data?: Record<string, unknown> };
}

/** Message from the page to the worker. */
export type ToWorker =
  /**
   * Opens a station: its address, or `SIM` with the virtual arm's speed, or `SERIAL` with the port.
   */
  | { kind: "open"; url: string }
  | { kind: "send"; message: RpcMessage }
  /**
   * Starts a jog and keeps it alive until `release`. `every` and `most` are in ms by the worker's
   * clock.
   */
  | { kind: "jog"; message: RpcMessage; every: number; most: number }
  | { kind: "release" }
  /** Sign of life of the page's main thread: a jog must not continue if the page hangs. */
  | { kind: "alive" }
  /** With a port: connects another client to the station in the worker. */
  | { kind: "join" }
  /** The page closes: whatever it started on a real arm is stopped before anything else. */
  | { kind: "leave" }
  /** A lost port has been chosen again. */
  | { kind: "port"; url: string }
  /** Requests the bytes exchanged between driver and arm. */
  | { kind: "trace" }
  /**
   * Writes a program of the virtual arm's library or, without `bytes`, reads it, since it may be
   * too large for a message. Answered like a request.
   */
  | { kind: "file"; id: number; name: string; bytes?: ArrayBuffer }
  | { kind: "close" };

/** Prefix of the address of a virtual arm in the worker. */
export const SIM = "sim:";
/** Prefix of the address of a real arm at a port of the browser. */
export const SERIAL = "serial:";

/** Message from the worker to the page. */
export type FromWorker =
  | { kind: "opened" }
  | { kind: "heard"; message: RpcMessage }
  | { kind: "closed"; code: number }
  | { kind: "traced"; file: Uint8Array<ArrayBuffer> }
  /**
   * From this time on, Unix s, the virtual arm's clock is `ahead` seconds before the wall clock.
   */
  | { kind: "jumped"; from: number; ahead: number };

/** Code of `closed` if the worker itself could not be started. */
export const NO_WORKER = 0;
/** Codes of a serial port: another program has it, it is not there, no arm answers. */
export const PORT_BUSY = 4500;
export const PORT_GONE = 4501;
export const PORT_SILENT = 4502;
