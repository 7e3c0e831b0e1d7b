// Worker that reads files with files.wasm, which is loaded with the first file.
import { load } from "../../crates/magician-wasm/node/reader.mjs";

let reader: ReturnType<typeof load> | null = null;

async function loaded(module: string): ReturnType<typeof load> {
  const answer = await fetch(module);
  if (!answer.ok) throw new Error(`${module}: ${answer.status}`);
  return load(await answer.arrayBuffer());
}

self.onmessage = async ({ data }: MessageEvent<{ module: string; request: Uint8Array }>) => {
  try {
    const read = await (reader ??= loaded(data.module));
    const answer = read(data.request);
    postMessage(answer, { transfer: [answer.buffer] });
  } catch (error) {
    console.warn(String(error));
    postMessage(null);
  }
};
