// Page without a network: its service worker, and newer builds, which are offered and never applied
// automatically.
import * as store from "./store";
import { until } from "./until";

/**
 * Delay before the offline copy is loaded at a first visit, ms. It keeps the network free for what
 * the user opens.
 */
const FIRST_VISIT_DELAY = 10_000;

/** Resolves after `FIRST_VISIT_DELAY`, once no arm is being connected. */
async function waitUntilQuiet(): Promise<void> {
  await new Promise((done) => setTimeout(done, FIRST_VISIT_DELAY));
  await until(() => store.socket.value !== "connecting");
}

export async function keepOffline(): Promise<void> {
  // Service workers need a secure origin: https, or this computer.
  if (!("serviceWorker" in navigator) || import.meta.env.DEV) return;
  if (navigator.serviceWorker.controller === null) await waitUntilQuiet();
  try {
    const found = await navigator.serviceWorker.register("./sw.js", { scope: "./", updateViaCache: "none" });
    const look = () => {
      const waiting = found.waiting;
      // Without a page of an earlier build there is nothing to update.
      store.update.value =
        waiting !== null && navigator.serviceWorker.controller !== null ? () => offerUpdate(waiting) : null;
    };
    look();
    found.addEventListener("updatefound", () => found.installing?.addEventListener("statechange", look));
    document.addEventListener("visibilitychange", () => document.hidden || void found.update().catch(() => {}));
  } catch {
    // A browser without storage rejects the registration. The page then has no offline copy.
  }
}

function offerUpdate(waiting: ServiceWorker): void {
  navigator.serviceWorker.addEventListener("controllerchange", () => location.reload(), { once: true });
  waiting.postMessage("take");
}
