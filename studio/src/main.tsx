// Entry point: the frame of the page, its routes, and the state that <body> exposes.
import { effect } from "@preact/signals";
import { render } from "preact";
import "./app.css";
import { readSlip } from "./class";
import { t } from "./i18n";
import { phase } from "./jog";
import { listen } from "./keys";
import { keepOffline } from "./offline";
import "./ring";
import * as session from "./session";
import { lastBackend } from "./settings";
import * as store from "./store";
import { App } from "./ui/app";
import { loadPanel } from "./ui/routes";
import { followHistory, restoreScroll } from "./ui/scroll";
import "./hidden";

function followHash(): void {
  const [wanted = "", query] = location.hash.replace(/^#\//, "").split("?");
  if (query !== undefined) {
    readSlip(new URLSearchParams(query));
    // The code of a slip must not stay in the history of a shared tablet.
    history.replaceState(history.state, "", `#/${wanted}`);
  }
  store.hash.value = wanted;
}

function exposeState(): void {
  const data = document.body.dataset;
  const say = (name: string, value: () => unknown) =>
    effect(() => {
      data[name] = String(value());
    });
  say("backend", () => store.backend.value);
  say("link", () => store.link.value);
  say("stale", () => store.stale.value || store.state.value === null);
  say("lease", () => (store.socket.value === "lost" ? "unknown" : store.lease.value));
  say("moving", () =>
    store.lastActivity.value?.isMoving ? "unknown" : store.isUp.value && store.state.value?.moving === true,
  );
  say("jog", () =>
    phase.value === "idle" && store.isUp.value && store.state.value?.jog != null ? "running" : phase.value,
  );
  say("job", () => store.jobState.value);
  say("alarm", () => store.alarms.value.length > 0);
  say("alarmHolds", () => store.isQueueHeld.value);
  effect(() => {
    const route = store.route.value;
    // A panel that is loaded later is painted later.
    void loadPanel(route).then(() => {
      requestAnimationFrame(() =>
        requestAnimationFrame(() => {
          if (store.route.peek() !== route) return;
          data.route = route;
          restoreScroll();
        }),
      );
    });
  });
}

/**
 * Connects to the station that serves this page. A page of static files reconnects to what it had
 * before.
 */
async function connectToServer(): Promise<void> {
  let isServed = false;
  try {
    const answer = await fetch(location.pathname, { method: "HEAD" });
    isServed = answer.ok && answer.headers.has("x-magician-api");
  } catch {
    // Offline.
  }
  store.isStatic.value = !isServed;
  if (!isServed) void keepOffline();
  if (store.backend.value !== "none") return;
  const url = session.apiUrl(location.origin);
  if (isServed && url !== null) session.connect(url, session.keptToken(), session.keptPupil());
  else if (!isServed && lastBackend.value === "sim") session.connectSim();
}

effect(() => {
  document.documentElement.lang = t("language.tag");
});
followHash();
followHistory();
addEventListener("hashchange", followHash);
// Closing the page stops what it started, so the browser asks first.
addEventListener("beforeunload", (event) => {
  const goesOn = store.isBusy.value || (store.isUp.value && store.state.value?.moving === true);
  if (goesOn && store.lease.value === "mine") event.preventDefault();
});
listen();
exposeState();
const root = document.getElementById("app");
if (root !== null) {
  root.textContent = "";
  render(<App />, root);
}
requestAnimationFrame(() => requestAnimationFrame(() => (document.body.dataset.ready = "true")));
void connectToServer();
