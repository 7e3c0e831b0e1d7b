// Region that the tip reaches at its height. Requested from the station when the height or the tool
// changes.
import { effect, signal } from "@preact/signals";
import { call } from "../session";
import * as store from "../store";

export const reach = signal<{ outlines: number[][][]; z: number } | null>(null);

/** Shortest interval between two requests, ms. */
const PAUSE = 250;
let asked = "";
let busy = false;

effect(() => {
  const state = store.state.value;
  const bias = store.model.value?.tool.bias;
  if (state === null) {
    reach.value = null;
    asked = "";
  } else if (bias && store.isUp.value) {
    void look(Math.round(state.z), bias);
  }
});

async function look(z: number, tool: number[]): Promise<void> {
  const wanted = `${z} ${String(tool)}`;
  if (busy || wanted === asked) return;
  busy = true;
  asked = wanted;
  try {
    const { outlines } = await call("motion.reach", { z, tool });
    reach.value = { outlines, z };
  } catch {
    // Height out of reach, or a lost line: the last outline is removed.
    reach.value = null;
  }
  setTimeout(() => {
    busy = false;
    const state = store.state.peek();
    const bias = store.model.peek()?.tool.bias;
    if (state !== null && bias) void look(Math.round(state.z), bias);
  }, PAUSE);
}
