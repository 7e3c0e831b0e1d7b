// Hidden pages release their WebSocket: a station accepts 128 connections, and a class has more
// tabs than pupils.
import { myPlace, myTurn } from "./class";
import { releaseConnection, restoreConnection } from "./session";
import * as store from "./store";

/**
 * Time in the background after which the connection is released, ms. A choice between free
 * connections and a page that is current when the user returns.
 */
const HIDDEN_TIMEOUT = 60_000;

let timer: ReturnType<typeof setTimeout> | undefined;
let isReleased = false;

/**
 * True if releasing the connection would lose something: a held arm and what runs on it, a turn, or
 * a place in a queue.
 */
const isConnectionNeeded = (): boolean =>
  store.arms.value.some(({ holder }) => holder !== null && holder.session === store.session.value) ||
  myTurn.value !== null ||
  myPlace.value !== null;

function releaseIfHidden(): void {
  if (!document.hidden || store.backend.value !== "station") return;
  if (store.socket.value !== "up" || isConnectionNeeded())
    return void (timer = setTimeout(releaseIfHidden, HIDDEN_TIMEOUT));
  isReleased = true;
  releaseConnection();
}

document.addEventListener("visibilitychange", () => {
  clearTimeout(timer);
  if (document.hidden) timer = setTimeout(releaseIfHidden, HIDDEN_TIMEOUT);
  else if (isReleased) {
    isReleased = false;
    restoreConnection();
  }
});
