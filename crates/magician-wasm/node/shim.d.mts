// The types of shim.mjs, for pages.

export type Out =
  | { kind: "text"; session: number; payload: string }
  /** Of a file that is to be read: its id in four bytes, then what `files.wasm` takes. */
  | { kind: "frame" | "line" | "close" | "trace" | "file"; session: number; payload: Uint8Array };

export interface Station {
  /** Text of a session; an empty one ends it. `trace` to session 0 asks for a trace file. */
  rpc(session: number, text: string): void;
  /** Does what is due; when the next turn is due, ms. */
  turn(): number;
  out(): Out | null;
  lineIn(bytes: Uint8Array): void;
  lineIs(there: boolean): void;
  /** What came of a file; nothing where its reader failed. */
  fileIn(id: number, answer: Uint8Array): void;
  /** Keeps a program; why not, as text. */
  programIn(name: string, bytes: Uint8Array): Uint8Array | null;
  programOut(name: string): Uint8Array | null;
}

export function load(
  source: BufferSource,
  now?: () => number,
): Promise<{ open(config: unknown): Station; memory: WebAssembly.Memory }>;
