// The worker that holds the WebSocket to a station.
import type { FromWorker, ToWorker, Wire } from "./carrier";
import { JogKeeper } from "./keeper";

const tell = (message: FromWorker) => postMessage(message);
let socket: WebSocket | null = null;

const send = (message: Wire) => {
  if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message));
};
const keeper = new JogKeeper(send);

function open(url: string): void {
  socket?.close();
  let made: WebSocket;
  try {
    made = new WebSocket(url, "magician.v1");
  } catch {
    tell({ kind: "closed", code: 1006 });
    return;
  }
  socket = made;
  made.onopen = () => socket === made && tell({ kind: "opened" });
  made.onmessage = (event: MessageEvent<string>) => {
    if (socket !== made) return;
    const message = JSON.parse(event.data) as Wire;
    keeper.heard(message);
    tell({ kind: "heard", message });
  };
  made.onclose = (event) => {
    keeper.release();
    if (socket === made) {
      socket = null;
      tell({ kind: "closed", code: event.code });
    }
  };
}

onmessage = (event: MessageEvent<ToWorker>) => {
  const order = event.data;
  switch (order.kind) {
    case "open":
      return open(order.url);
    case "send":
      return send(order.message);
    case "jog":
      return keeper.start(order.message, order.every, order.most);
    case "release":
      return keeper.release();
    case "alive":
      return keeper.isAlive();
    case "close":
      keeper.release();
      socket?.close();
      socket = null;
  }
};
