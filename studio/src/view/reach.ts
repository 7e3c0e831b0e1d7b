// Region that the tip reaches at its height. Requested from the station when the height or the tool
// changes.
import { effect, signal } from "@preact/signals";
import { call } from "../session";
import * as store from "../store";

export const reach = signal<{ outlines: number[][][]; z: number } | null>(null);

/** Shortest interval between two requests, ms. */
const REQUEST_INTERVAL = 250;
let requestedKey = "";
let isRequesting = false;

effect(() => {
  const state = store.state.value;
  const bias = store.model.value?.tool.bias;
  if (state === null) {
    reach.value = null;
    requestedKey = "";
  } else if (bias && store.isUp.value) {
    void requestReach(Math.round(state.z), bias);
  }
});

async function requestReach(z: number, tool: number[]): Promise<void> {
  const wanted = `${z} ${String(tool)}`;
  if (isRequesting || wanted === requestedKey) return;
  isRequesting = true;
  requestedKey = wanted;
  try {
    const { outlines } = await call("motion.reach", { z, tool });
    reach.value = { outlines, z };
  } catch {
    // Height out of reach, or a lost line: the last outline is removed.
    reach.value = null;
  }
  setTimeout(() => {
    isRequesting = false;
    const state = store.state.peek();
    const bias = store.model.peek()?.tool.bias;
    if (state !== null && bias) void requestReach(Math.round(state.z), bias);
  }, REQUEST_INTERVAL);
}
