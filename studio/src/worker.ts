// Worker that owns the connection: a WebSocket to a station, or the station itself with a virtual
// arm or with a real one at a serial port.

import { JogKeeper } from "./keeper";
import { type FromWorker, PORT_GONE, type RpcMessage, SERIAL, SIM, type ToWorker } from "./messages";
import { SerialLine } from "./serial";
import { WorkerStation } from "./station";

const post = (message: FromWorker) => postMessage(message);

/** Connection. Messages sent after its end are discarded. */
interface StationConnection {
  send(message: RpcMessage): void;
  /** Transfers a program without a message, for a station in this worker. */
  file?(name: string, bytes?: ArrayBuffer): ArrayBuffer;
  close(): void;
}
let connection: StationConnection | null = null;
const keeper = new JogKeeper((message) => connection?.send(message));
/**
 * Station with the virtual arm. It lasts as long as the worker, so that the arm keeps its pose
 * across connections.
 */
let sim: Promise<WorkerStation> | null = null;
/** Station at the serial port, until the page leaves it. */
let real: Promise<WorkerStation> | null = null;
/** Resolves when the previous station has released its port. */
let portReleased: Promise<unknown> = Promise.resolve();

/** Client for a connection, active while that is the page's current one. */
function clientFor(isOn: () => boolean) {
  return {
    onMessage(message: RpcMessage) {
      if (!isOn()) return;
      keeper.onMessage(message);
      post({ kind: "heard", message });
    },
    onClosed(code: number) {
      if (!isOn()) return;
      keeper.release();
      connection = null;
      post({ kind: "closed", code });
    },
  };
}

function open(url: string): void {
  close();
  if (url.startsWith(SIM)) {
    sim ??= WorkerStation.simulated(moduleUrl(), Number(url.slice(SIM.length)), (from, ahead) =>
      post({ kind: "jumped", from, ahead }),
    );
    return void openStation(sim, () => (sim = null));
  }
  if (url.startsWith(SERIAL)) {
    real ??= portReleased
      .then(() => SerialLine.open(url.slice(SERIAL.length)))
      .then((line) => WorkerStation.atLine(moduleUrl(), line));
    return void openStation(real, () => (real = null));
  }
  let socket: WebSocket;
  try {
    socket = new WebSocket(url, "magician.v1");
  } catch {
    post({ kind: "closed", code: 1006 });
    return;
  }
  const mine: StationConnection = {
    send: (message) => {
      if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message));
    },
    close: () => socket.close(),
  };
  connection = mine;
  const { onMessage, onClosed } = clientFor(() => connection === mine);
  socket.onopen = () => connection === mine && post({ kind: "opened" });
  socket.onmessage = (event: MessageEvent<string>) => onMessage(JSON.parse(event.data) as RpcMessage);
  socket.onclose = (event) => onClosed(event.code);
}

const moduleUrl = () => new URL("arm.wasm", location.href);

async function openStation(opening: Promise<WorkerStation>, failed: () => void): Promise<void> {
  const mine: StationConnection = { send: () => {}, close: () => {} };
  connection = mine;
  const hears = clientFor(() => connection === mine);
  try {
    const station = await opening;
    if (connection !== mine) return;
    const session = station.connect(hears);
    mine.send = (message) => station.send(session, message);
    mine.file = (name, bytes) => station.file(name, bytes);
    mine.close = () => station.end(session);
    post({ kind: "opened" });
  } catch (error) {
    failed();
    if (typeof error === "number") return hears.onClosed(error);
    console.error(String(error));
    hears.onClosed(1006);
  }
}

/** Leaves the real arm, after stopping what moves. */
function leave(): void {
  keeper.release();
  const station = real;
  if (station === null) return;
  real = null;
  connection = null;
  portReleased = station.then((station) => station.leave()).catch(() => {});
}

async function choosePort(chosen: string): Promise<void> {
  try {
    await (await real)?.choosePort(chosen);
  } catch (code) {
    // The station goes on and still searches for the previous port.
    post({ kind: "closed", code: typeof code === "number" ? code : PORT_GONE });
  }
}

async function trace(): Promise<void> {
  const station = await (real ?? sim);
  if (station !== null) post({ kind: "traced", file: (await station.trace()) as Uint8Array<ArrayBuffer> });
}

/**
 * Connects another client to the station in the worker, with the same messages as over a WebSocket.
 */
async function join(port: MessagePort): Promise<void> {
  const station = await (real ?? sim);
  if (station === null) return port.close();
  const session = station.connect({ onMessage: (message) => port.postMessage(message), onClosed: () => port.close() });
  port.onmessage = (event: MessageEvent<RpcMessage>) => station.send(session, event.data);
}

function file(id: number, name: string, bytes?: ArrayBuffer): void {
  const answer = (message: RpcMessage) => post({ kind: "heard", message: { id, ...message } });
  try {
    if (connection?.file) answer({ result: connection.file(name, bytes) });
  } catch (error) {
    answer({ error: { code: 0, message: error instanceof Error ? error.message : String(error) } });
  }
}

function close(): void {
  keeper.release();
  connection?.close();
  connection = null;
}

self.onmessage = (event: MessageEvent<ToWorker>) => {
  const order = event.data;
  switch (order.kind) {
    case "open":
      return open(order.url);
    case "send":
      return connection?.send(order.message);
    case "jog":
      return keeper.start(order.message, order.every, order.most);
    case "release":
      return keeper.release();
    case "alive":
      return keeper.noteAlive();
    case "join":
      return void event.ports.map(join);
    case "trace":
      return void trace();
    case "port":
      return void choosePort(order.url.slice(SERIAL.length));
    case "leave":
      return leave();
    case "file":
      return file(order.id, order.name, order.bytes);
    case "close":
      leave();
      return close();
  }
};
