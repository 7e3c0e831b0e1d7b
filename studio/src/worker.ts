// The worker that holds the line: a WebSocket to a station, or the station itself with a virtual arm.
import { type FromWorker, SIM, type ToWorker, type Wire } from "./carrier";
import { JogKeeper } from "./keeper";
import { SimStation } from "./sim";

const tell = (message: FromWorker) => postMessage(message);

/** A connection: what is sent after its end is lost. */
interface Line {
  send(message: Wire): void;
  /** A program past the messages, of a station in this worker. */
  file?(name: string, bytes?: ArrayBuffer): ArrayBuffer;
  close(): void;
}
let line: Line | null = null;
const keeper = new JogKeeper((message) => line?.send(message));
/** A module is a station, and lasts as long as the worker: a virtual arm that is connected again stands where it stood. */
let sim: Promise<SimStation> | null = null;

/** What a connection hears as long as it is the one that the page has. */
function hearer(isOn: () => boolean) {
  return {
    heard(message: Wire) {
      if (!isOn()) return;
      keeper.heard(message);
      tell({ kind: "heard", message });
    },
    closed(code: number) {
      if (!isOn()) return;
      keeper.release();
      line = null;
      tell({ kind: "closed", code });
    },
  };
}

function open(url: string): void {
  close();
  if (url.startsWith(SIM)) return void openSim(Number(url.slice(SIM.length)));
  let socket: WebSocket;
  try {
    socket = new WebSocket(url, "magician.v1");
  } catch {
    tell({ kind: "closed", code: 1006 });
    return;
  }
  const mine: Line = {
    send: (message) => {
      if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message));
    },
    close: () => socket.close(),
  };
  line = mine;
  const { heard, closed } = hearer(() => line === mine);
  socket.onopen = () => line === mine && tell({ kind: "opened" });
  socket.onmessage = (event: MessageEvent<string>) => heard(JSON.parse(event.data) as Wire);
  socket.onclose = (event) => closed(event.code);
}

async function openSim(speed: number): Promise<void> {
  const mine: Line = { send: () => {}, close: () => {} };
  line = mine;
  const hears = hearer(() => line === mine);
  sim ??= SimStation.open(new URL("arm.wasm", location.href), speed);
  try {
    const station = await sim;
    if (line !== mine) return;
    const session = station.connect(hears);
    mine.send = (message) => station.send(session, message);
    mine.file = (name, bytes) => station.file(name, bytes);
    mine.close = () => station.end(session);
    tell({ kind: "opened" });
  } catch (error) {
    sim = null;
    console.error(String(error));
    hears.closed(1006);
  }
}

/** Another client of the virtual arm's station: messages as over a WebSocket, by a port. */
async function join(port: MessagePort): Promise<void> {
  const station = await sim;
  if (station === null) return port.close();
  const session = station.connect({ heard: (message) => port.postMessage(message), closed: () => port.close() });
  port.onmessage = (event: MessageEvent<Wire>) => station.send(session, event.data);
}

function file(id: number, name: string, bytes?: ArrayBuffer): void {
  const answer = (message: Wire) => tell({ kind: "heard", message: { id, ...message } });
  try {
    if (line?.file) answer({ result: line.file(name, bytes) });
  } catch (error) {
    answer({ error: { code: 0, message: error instanceof Error ? error.message : String(error) } });
  }
}

function close(): void {
  keeper.release();
  line?.close();
  line = null;
}

onmessage = (event: MessageEvent<ToWorker>) => {
  const order = event.data;
  switch (order.kind) {
    case "open":
      return open(order.url);
    case "send":
      return line?.send(order.message);
    case "jog":
      return keeper.start(order.message, order.every, order.most);
    case "release":
      return keeper.release();
    case "alive":
      return keeper.isAlive();
    case "join":
      return void event.ports.map(join);
    case "file":
      return file(order.id, order.name, order.bytes);
    case "close":
      return close();
  }
};
