// Types of reader.mjs, for pages.

export function load(source: BufferSource): Promise<(request: Uint8Array) => Uint8Array>;
