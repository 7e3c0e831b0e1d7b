// The page without a network: its service worker, and a newer build, which is offered and never taken by itself.
import { effect } from "@preact/signals";
import * as store from "./store";

/** Of a first visit, ms: until then the line is for what the person opens, and the copy of all files waits. */
const FIRST = 5000;

/** After the first seconds, and not while an arm is being connected. */
async function quiet(): Promise<void> {
  await new Promise((done) => setTimeout(done, FIRST));
  await new Promise<void>((done) => {
    const end = effect(() => {
      if (store.socket.value === "connecting") return;
      queueMicrotask(() => end());
      done();
    });
  });
}

export async function keepOffline(): Promise<void> {
  // Only where the browser trusts where the page came from: https, or this computer.
  if (!("serviceWorker" in navigator) || import.meta.env.DEV) return;
  if (navigator.serviceWorker.controller === null) await quiet();
  try {
    const found = await navigator.serviceWorker.register("./sw.js", { scope: "./", updateViaCache: "none" });
    const look = () => {
      const waiting = found.waiting;
      // Without a page of the build before there is nothing to take the place of.
      store.update.value = waiting !== null && navigator.serviceWorker.controller !== null ? () => take(waiting) : null;
    };
    look();
    found.addEventListener("updatefound", () => found.installing?.addEventListener("statechange", look));
    document.addEventListener("visibilitychange", () => document.hidden || void found.update().catch(() => {}));
  } catch {
    // A browser that keeps nothing has the page as long as it is open.
  }
}

function take(waiting: ServiceWorker): void {
  navigator.serviceWorker.addEventListener("controllerchange", () => location.reload(), { once: true });
  waiting.postMessage("take");
}
