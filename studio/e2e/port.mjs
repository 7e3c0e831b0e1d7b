// Mock serial port of the browser, connected to a virtual arm of `magician sim` by a WebSocket.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { createHash } from "node:crypto";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { createServer } from "node:http";
import { connect } from "node:net";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { setTimeout as sleep } from "node:timers/promises";

/** Runs in page and worker: replaces `navigator.serial` by one port, connected to the bridge. */
function mock(bridge) {
  const state = { granted: false, ports: [] };
  class Port extends EventTarget {
    connected = true;
    readable = null;
    writable = null;
    getInfo = () => ({ usbVendorId: 0x1a86, usbProductId: 0x7523 });
    setSignals = async () => {};
    async open({ baudRate }) {
      if (baudRate !== 115200) throw new TypeError(`baud rate ${baudRate}`);
      const socket = new WebSocket(bridge);
      socket.binaryType = "arraybuffer";
      await new Promise((done, failed) => {
        socket.onopen = done;
        socket.onclose = () => failed(new DOMException("Failed to open serial port.", "NetworkError"));
      });
      this.socket = socket;
      let reads;
      const begin = () => (this.readable = new ReadableStream({ start: (to) => (reads = to) }));
      begin();
      this.writable = new WritableStream({
        write: (bytes) => {
          if (socket.readyState !== 1) throw new DOMException("The device has been lost.", "NetworkError");
          socket.send(bytes);
        },
      });
      socket.onmessage = ({ data }) => {
        // A text is an error of the stream: the port continues with a new stream.
        if (typeof data === "string") {
          const broken = reads;
          begin();
          return broken.error(new DOMException("", data));
        }
        try {
          reads.enqueue(new Uint8Array(data));
        } catch {
          begin();
          reads.enqueue(new Uint8Array(data));
        }
      };
      socket.onclose = () => {
        this.readable = null;
        try {
          reads.error(new DOMException("The device has been lost.", "NetworkError"));
        } catch {}
      };
    }
    async close() {
      this.socket?.close();
      this.readable = this.writable = null;
    }
  }
  const serial = new EventTarget();
  const ask = () =>
    new Promise((done) => (new WebSocket(`${bridge}state`).onmessage = ({ data }) => done(JSON.parse(data))));
  serial.getPorts = async () => {
    const { granted, there } = await ask();
    if (!granted || !there) {
      state.ports.splice(0);
      return [];
    }
    // A port that returns is a new object.
    if (state.ports[0]?.number !== there) state.ports = [Object.assign(new Port(), { number: there })];
    return state.ports;
  };
  serial.requestPort = async ({ filters }) => {
    if (!filters.some((one) => one.usbVendorId === 0x1a86 && one.usbProductId === 0x7523))
      throw new TypeError("filters");
    const { granted } = await ask();
    if (!granted) throw new DOMException("No port selected by the user.", "NotFoundError");
    return (await serial.getPorts())[0];
  };
  Object.defineProperty(navigator, "serial", { configurable: true, value: serial });
}

export const mockOf = (bridge) => `(${mock})(${JSON.stringify(bridge)});`;

/** Splits bytes into whole frames, as they are sent. */
function framesOf(bytes) {
  const frames = [];
  let rest = bytes;
  while (rest.length >= 6) {
    if (rest[0] !== 0xaa || rest[1] !== 0xaa || rest.length < rest[2] + 4) {
      rest = rest.subarray(1);
      continue;
    }
    const [length, id, ctrl] = [rest[2], rest[3], rest[4]];
    frames.push({ id, ctrl, params: rest.subarray(5, 3 + length) });
    rest = rest.subarray(length + 4);
  }
  return frames;
}

const GET = (id) => Buffer.from([0xaa, 0xaa, 2, id, 0, (256 - id) & 255]);

/** The arm and its cable: records traffic with times, and can disturb it. */
export class Cable {
  granted = true;
  /** Number of the plug; 0 while unplugged. */
  there = 1;
  isBusy = false;
  /** Largest number of bytes per read. */
  piece = Infinity;
  noise = false;
  sent = [];
  /** Number of times the port was opened. */
  opens = 0;
  sockets = new Set();

  constructor(program) {
    this.program = program;
  }

  async start() {
    if (this.server) return;
    this.server = createServer((_, response) => response.end());
    this.server.on("upgrade", (request, socket) => this.opened(request, socket));
    await new Promise((done) => this.server.listen(0, "127.0.0.1", done));
    this.bridge = `ws://127.0.0.1:${this.server.address().port}/`;
    await this.newArm();
  }

  /** Starts a new arm, as after power-up. */
  async newArm() {
    this.folder ??= mkdtempSync(join(tmpdir(), "studio-port-"));
    const free = createServer();
    await new Promise((done) => free.listen(0, "127.0.0.1", done));
    const { port } = free.address();
    await new Promise((done) => free.close(done));
    this.port = port;
    this.child = spawn(
      this.program,
      ["sim", "--tcp", `127.0.0.1:${port}`, "--trace", join(this.folder, "arm.pcapng")],
      { stdio: ["ignore", "pipe", "ignore"] },
    );
    await new Promise((done) => this.child.stdout.once("data", done));
    this.judge?.destroy();
    this.judge = connect(port, "127.0.0.1");
    this.heard = Buffer.alloc(0);
    this.judge.on("data", (bytes) => (this.heard = Buffer.concat([this.heard, bytes])));
  }

  opened(request, socket) {
    const isState = request.url === "/state";
    if (!isState && (this.isBusy || !this.there)) return socket.destroy();
    const key = createHash("sha1")
      .update(`${request.headers["sec-websocket-key"]}258EAFA5-E914-47DA-95CA-C5AB0DC85B11`)
      .digest("base64");
    socket.write(
      `HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Accept: ${key}\r\n\r\n`,
    );
    socket.setNoDelay(true);
    if (isState) {
      this.frame(socket, 1, Buffer.from(JSON.stringify({ granted: this.granted, there: this.there })));
      return socket.end(Buffer.from([0x88, 0])).on("error", () => {});
    }
    const arm = this.isMute ? null : connect(this.port, "127.0.0.1");
    arm?.setNoDelay(true);
    this.sockets.add(socket);
    this.opens++;
    const end = () => {
      arm?.destroy();
      socket.destroy();
      this.sockets.delete(socket);
    };
    let rest = Buffer.alloc(0);
    socket.on("data", (bytes) => {
      rest = Buffer.concat([rest, bytes]);
      for (;;) {
        if (rest.length < 6) return;
        const long = (rest[1] & 127) === 126;
        const [length, at] = long ? [rest.readUInt16BE(2), 4] : [rest[1] & 127, 2];
        if (rest.length < at + 4 + length) return;
        const kind = rest[0] & 15;
        const data = Buffer.from(rest.subarray(at + 4, at + 4 + length)).map(
          (byte, nth) => byte ^ rest[at + (nth & 3)],
        );
        rest = rest.subarray(at + 4 + length);
        if (kind === 8) return end();
        if (kind !== 2) continue;
        for (const frame of framesOf(data)) this.sent.push({ at: performance.now(), ...frame });
        arm?.write(data);
      }
    });
    arm?.on("data", (bytes) => {
      const dirt = this.noise ? Buffer.from([0xff, 0x00, 0xaa, 0x55, 0x4d, 0x0a]) : Buffer.alloc(0);
      const all = Buffer.concat([dirt, bytes]);
      for (let from = 0; from < all.length; from += this.piece)
        this.frame(socket, 2, all.subarray(from, from + this.piece));
    });
    arm?.on("error", end);
    socket.on("error", end);
    socket.on("close", end);
  }

  frame(socket, kind, data) {
    const head =
      data.length < 126
        ? Buffer.from([0x80 | kind, data.length])
        : Buffer.from([0x80 | kind, 126, data.length >> 8, data.length & 255]);
    socket.write(Buffer.concat([head, data]));
  }

  /** Causes an error of the stream: BufferOverrunError, FramingError, BreakError, ParityError. */
  error(name) {
    for (const socket of this.sockets) this.frame(socket, 1, Buffer.from(name));
  }

  unplug() {
    this.there = 0;
    for (const socket of this.sockets) socket.destroy();
  }

  plug() {
    this.there = this.number = (this.number ?? 1) + 1;
  }

  /** Asks the arm directly. */
  async get(id) {
    this.heard = Buffer.alloc(0);
    this.judge.write(GET(id));
    for (let tries = 0; tries < 2000; tries++) {
      const frame = framesOf(this.heard).find((one) => one.id === id);
      if (frame) return frame.params;
      await sleep(1);
    }
    throw new Error(`the arm does not answer ${id}`);
  }

  async pose() {
    const params = await this.get(10);
    return Array.from({ length: 8 }, (_, nth) => params.readFloatLE(4 * nth));
  }

  /** True if a laser is on. */
  async burns() {
    const params = await this.get(61);
    return params[0] === 1 && params[1] === 1;
  }

  /** Time at which the arm came to rest, by the test's clock: the last change of its pose. */
  async timeOfRest(within = 5000) {
    let [before, changed] = [null, performance.now()];
    for (const ends = performance.now() + within; performance.now() < ends && performance.now() - changed < 700; ) {
      const asked = performance.now();
      const now = String(await this.pose());
      if (now !== before) [before, changed] = [now, asked];
      await sleep(2);
    }
    return changed;
  }

  /**
   * Time from the last motion command until the arm rested, ms by the arm's clock, since this
   * machine may be busy.
   */
  async hasMovedOn(isMove) {
    await this.timeOfRest();
    const frames = this.traced();
    const last = frames.findLast((frame) => frame.toArm && isMove(frame));
    const poses = frames.filter((frame) => !frame.toArm && frame.id === 10);
    const end = String(poses.at(-1).params);
    return (poses.findLast((frame) => String(frame.params) !== end)?.at ?? 0) - last.at;
  }

  /** Traffic at the arm, with times in ms. */
  traced() {
    const file = readFileSync(join(this.folder, "arm.pcapng"));
    const frames = [];
    for (let at = 0; at + 12 <= file.length; at += file.readUInt32LE(at + 4)) {
      if (file.readUInt32LE(at) !== 6 || at + file.readUInt32LE(at + 4) > file.length) continue;
      const time = (file.readUInt32LE(at + 12) * 2 ** 32 + file.readUInt32LE(at + 16)) / 1000;
      const long = file.readUInt32LE(at + 20);
      const flags = file.readUInt32LE(at + 28 + Math.ceil(long / 4) * 4 + 4);
      const frame = framesOf(file.subarray(at + 28, at + 28 + long))[0];
      if (frame) frames.push({ at: time, toArm: (flags & 3) === 2, ...frame });
    }
    return frames;
  }

  /** True if the arm is moving. */
  async moves() {
    const before = String(await this.pose());
    await sleep(60);
    return String(await this.pose()) !== before;
  }

  async untilMoves(within = 8000) {
    for (const ends = performance.now() + within; performance.now() < ends; ) if (await this.moves()) return;
    assert.fail("the arm does not move");
  }

  since(at) {
    return this.sent.filter((frame) => frame.at >= at);
  }

  end() {
    this.child?.kill();
    this.judge?.destroy();
    for (const socket of this.sockets) socket.destroy();
    this.server?.closeAllConnections();
    this.server?.close();
    if (this.folder) rmSync(this.folder, { recursive: true, force: true });
  }
}
