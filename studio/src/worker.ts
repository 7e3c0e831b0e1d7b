// The worker that holds the line: a WebSocket to a station, or the station itself with a virtual arm or a real one at a serial port.
import { type FromWorker, PORT_GONE, SERIAL, SIM, type ToWorker, type Wire } from "./carrier";
import { JogKeeper } from "./keeper";
import { SerialLine } from "./serial";
import { WorkerStation } from "./sim";

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
let sim: Promise<WorkerStation> | null = null;
/** The station at the serial port: until the page is done with it. */
let real: Promise<WorkerStation> | null = null;
/** The port of the one before is not free until then. */
let left: Promise<unknown> = Promise.resolve();

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

/** Done with the real arm: what moves there is stopped first. */
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
    // The station goes on: the port of before is still looked for.
    tell({ kind: "closed", code: typeof code === "number" ? code : PORT_GONE });
  }
}

async function trace(): Promise<void> {
  const station = await (real ?? sim);
  if (station !== null) tell({ kind: "traced", file: (await station.trace()) as Uint8Array<ArrayBuffer> });
}

/** Another client of the station in the worker: messages as over a WebSocket, by a port. */
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
