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
  /** A station: its address, or `SIM` and the virtual arm's speed, or `SERIAL` and the port. */
  | { kind: "open"; url: string }
  | { kind: "send"; message: Wire }
  /** Starts a jog, and keeps it up until `release`: `every` and `most` in ms, by the clock of the worker. */
  | { kind: "jog"; message: Wire; every: number; most: number }
  | { kind: "release" }
  /** The page's main thread is alive: a jog is not kept up for a page that hangs. */
  | { kind: "alive" }
  /** With a port: another client of the station in the worker. */
  | { kind: "join" }
  /** The page goes: what it has set going on a real arm is stopped before anything else. */
  | { kind: "leave" }
  /** A lost port was chosen again. */
  | { kind: "port"; url: string }
  /** Asks for the bytes that passed between driver and arm. */
  | { kind: "trace" }
  /** A program of the virtual arm's library, which is kept, or without bytes given: what a message has no room for. Answered as a request. */
  | { kind: "file"; id: number; name: string; bytes?: ArrayBuffer }
  | { kind: "close" };

/** What the address of a virtual arm in the worker begins with. */
export const SIM = "sim:";
/** .. and that of a real arm at a port of the browser. */
export const SERIAL = "serial:";

/** What the worker tells the page. */
export type FromWorker =
  | { kind: "opened" }
  | { kind: "heard"; message: Wire }
  | { kind: "closed"; code: number }
  | { kind: "traced"; file: Uint8Array<ArrayBuffer> }
  /** From this time on, Unix s, the clock of the virtual arm is so far ahead of the wall clock, s. */
  | { kind: "jumped"; from: number; ahead: number };

/** The code of `closed` where the worker itself could not be started. */
export const NO_WORKER = 0;
/** Codes of a serial port: nobody lets it be opened; it is not there; no arm answers. */
export const PORT_BUSY = 4500;
export const PORT_GONE = 4501;
export const PORT_SILENT = 4502;
