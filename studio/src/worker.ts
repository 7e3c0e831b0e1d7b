// Worker that owns the connection: a WebSocket to a station, or the station itself with a virtual
// arm or with a real one at a serial port.
import { type FromWorker, PORT_GONE, SERIAL, SIM, type ToWorker, type Wire } from "./carrier";
import { JogKeeper } from "./keeper";
import { SerialLine } from "./serial";
import { WorkerStation } from "./sim";

const tell = (message: FromWorker) => postMessage(message);

/** Connection. Messages sent after its end are discarded. */
interface Line {
  send(message: Wire): void;
  /** Transfers a program without a message, for a station in this worker. */
  file?(name: string, bytes?: ArrayBuffer): ArrayBuffer;
  close(): void;
}
let line: Line | null = null;
const keeper = new JogKeeper((message) => line?.send(message));
/**
 * Station with the virtual arm. It lasts as long as the worker, so that the arm keeps its pose
 * across connections.
 */
let sim: Promise<WorkerStation> | null = null;
/** Station at the serial port, until the page leaves it. */
let real: Promise<WorkerStation> | null = null;
/** Resolves when the previous station has released its port. */
let left: Promise<unknown> = Promise.resolve();

/** Client for a connection, active while that is the page's current one. */
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
  if (url.startsWith(SIM)) {
    sim ??= WorkerStation.simulated(MODULE(), Number(url.slice(SIM.length)), (from, ahead) =>
      tell({ kind: "jumped", from, ahead }),
    );
    return void openHere(sim, () => (sim = null));
  }
  if (url.startsWith(SERIAL)) {
    real ??= left
      .then(() => SerialLine.open(url.slice(SERIAL.length)))
      .then((line) => WorkerStation.atLine(MODULE(), line));
    return void openHere(real, () => (real = null));
  }
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

const MODULE = () => new URL("arm.wasm", location.href);

async function openHere(opening: Promise<WorkerStation>, failed: () => void): Promise<void> {
  const mine: Line = { send: () => {}, close: () => {} };
  line = mine;
  const hears = hearer(() => line === mine);
  try {
    const station = await opening;
    if (line !== mine) return;
    const session = station.connect(hears);
    mine.send = (message) => station.send(session, message);
    mine.file = (name, bytes) => station.file(name, bytes);
    mine.close = () => station.end(session);
    tell({ kind: "opened" });
  } catch (error) {
    failed();
    if (typeof error === "number") return hears.closed(error);
    console.error(String(error));
    hears.closed(1006);
  }
}

/** Leaves the real arm, after stopping what moves. */
function leave(): void {
  keeper.release();
  const station = real;
  if (station === null) return;
  real = null;
  line = null;
  left = station.then((station) => station.leave()).catch(() => {});
}

async function choosePort(chosen: string): Promise<void> {
  try {
    await (await real)?.choosePort(chosen);
  } catch (code) {
    // The station goes on and still searches for the previous port.
    tell({ kind: "closed", code: typeof code === "number" ? code : PORT_GONE });
  }
}

async function trace(): Promise<void> {
  const station = await (real ?? sim);
  if (station !== null) tell({ kind: "traced", file: (await station.trace()) as Uint8Array<ArrayBuffer> });
}

/**
 * Connects another client to the station in the worker, with the same messages as over a WebSocket.
 */
async function join(port: MessagePort): Promise<void> {
  const station = await (real ?? sim);
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

self.onmessage = (event: MessageEvent<ToWorker>) => {
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
