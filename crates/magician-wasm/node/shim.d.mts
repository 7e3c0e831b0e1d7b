// Types of shim.mjs, for pages.

export type Out =
  | { kind: "text"; session: number; payload: string }
  /** The payload of a file to read is its id in four bytes, then the request for `files.wasm`. */
  | { kind: "frame" | "line" | "close" | "trace" | "file"; session: number; payload: Uint8Array };

export interface Station {
  /** Passes text of a session; an empty text ends the session. `trace` to session 0 requests a trace file. */
  rpc(session: number, text: string): void;
  /** Runs everything that is due. Returns when the next turn is due, ms. */
  turn(): number;
  /** Returns the next output, or null. */
  out(): Out | null;
  lineIn(bytes: Uint8Array): void;
  lineIs(there: boolean): void;
  /** Passes the result of reading a file, empty if its reader failed. */
  fileIn(id: number, answer: Uint8Array): void;
  /** Stores a program. Returns an error as text, or null. */
  programIn(name: string, bytes: Uint8Array): Uint8Array | null;
  programOut(name: string): Uint8Array | null;
}

export function load(
  source: BufferSource,
  now?: () => number,
): Promise<{ open(config: unknown): Station; memory: WebAssembly.Memory }>;
