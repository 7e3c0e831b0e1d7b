// A page that nobody sees gives its socket up: a station has room for 128, and a class has more tabs than pupils.
import { myPlace, myTurn } from "./class";
import { rest, wake } from "./session";
import * as store from "./store";

/** A page is left alone for so long, ms. */
const UNSEEN = 60_000;

let timer: ReturnType<typeof setTimeout> | undefined;
let rests = false;

/** Whether something would be lost with the socket: an arm with what runs there, a turn, a place in a queue. */
const isKept = (): boolean =>
  store.arms.value.some(({ holder }) => holder !== null && holder.session === store.session.value) ||
  myTurn.value !== null ||
  myPlace.value !== null;

function giveUp(): void {
  if (!document.hidden || store.backend.value !== "station") return;
  if (store.socket.value !== "up" || isKept()) return void (timer = setTimeout(giveUp, UNSEEN));
  rests = true;
  rest();
}

document.addEventListener("visibilitychange", () => {
  clearTimeout(timer);
  if (document.hidden) timer = setTimeout(giveUp, UNSEEN);
  else if (rests) {
    rests = false;
    wake();
  }
});
