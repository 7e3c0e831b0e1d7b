// The types of shim.mjs, for pages.

export type Out =
  | { kind: "text"; session: number; payload: string }
  | { kind: "frame" | "line" | "close" | "trace"; session: number; payload: Uint8Array };

export interface Station {
  /** Text of a session; an empty one ends it. `trace` to session 0 asks for a trace file. */
  rpc(session: number, text: string): void;
  /** Does what is due; when the next turn is due, ms. */
  turn(): number;
  out(): Out | null;
  lineIn(bytes: Uint8Array): void;
  lineIs(there: boolean): void;
}

export function load(
  source: BufferSource,
  now?: () => number,
): Promise<{ open(config: unknown): Station; memory: WebAssembly.Memory }>;
