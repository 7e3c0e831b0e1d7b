// The line to a real arm: a serial port of the browser, opened in the worker, lost and found again.
import { PORT_BUSY, PORT_GONE } from "./carrier";

/** Not every browser has them. */
export const serial: Serial | undefined = navigator.serial;

/** The adapters that arms have: CP210x, CH340, CH9102, Arduino. */
const FILTERS = [
  { usbVendorId: 0x10c4, usbProductId: 0xea60 },
  { usbVendorId: 0x1a86, usbProductId: 0x7523 },
  { usbVendorId: 0x1a86, usbProductId: 0x55d4 },
  { usbVendorId: 0x2341 },
];
/** 8N1, no flow control, which is what browsers take unless told otherwise. */
const LINE = { baudRate: 115200, bufferSize: 16384 };
/** A port that was lost is looked for so often, ms; the browser's word of it may be missed. */
const LOOK = 500;
/** So many errors in a row without a byte between them are no noise. */
const ERRORS = 100;

const kind = (port: SerialPort) => `${port.getInfo().usbVendorId}:${port.getInfo().usbProductId}`;

/** The window asks which port: its place among those that are allowed, for the worker. Null where nothing was chosen. */
export async function choose(): Promise<string | null> {
  if (serial === undefined) return null;
  let port: SerialPort;
  try {
    port = await serial.requestPort({ filters: FILTERS });
  } catch (error) {
    if ((error as DOMException).name === "NotFoundError") return null;
    throw error;
  }
  return `${(await serial.getPorts()).indexOf(port)} ${kind(port)}`;
}

/** The port that was chosen, if it is there still. */
async function portOf(chosen: string): Promise<SerialPort> {
  const [at = "", of] = chosen.split(" ");
  const port = (await serial?.getPorts())?.[Number(at)];
  if (port === undefined || kind(port) !== of) throw PORT_GONE;
  return port;
}

/** Who carries the line on. */
interface Ends {
  heard(bytes: Uint8Array): void;
  is(there: boolean): void;
}

export class SerialLine {
  private writer: WritableStreamDefaultWriter<Uint8Array> | null = null;
  private reader: ReadableStreamDefaultReader<Uint8Array> | null = null;
  private ends: Ends | null = null;
  private timer: ReturnType<typeof setInterval> | undefined;
  private readonly looks = () => void this.look();
  private isOver = false;
  /** The other ports of its kind while it was there: none of them is this one. */
  private others: SerialPort[] = [];
  private looking = false;

  private constructor(private port: SerialPort) {}

  /** Opens a port, as `choose` names it; fails with a code of `closed`. */
  static async open(chosen: string): Promise<SerialLine> {
    const line = new SerialLine(await portOf(chosen));
    await line.opens();
    return line;
  }

  begin(ends: Ends): void {
    this.ends = ends;
    serial?.addEventListener("connect", this.looks);
    serial?.addEventListener("disconnect", this.looks);
    void this.pump();
  }

  say(bytes: Uint8Array): void {
    // What is said to a line that breaks is lost with it: the driver says nothing twice.
    this.writer?.write(bytes).catch(() => this.lost());
  }

  /** The person chose another port, or the same again, while it was lost. */
  async again(chosen: string): Promise<void> {
    const port = await portOf(chosen);
    if (this.writer !== null || this.looking) return;
    this.looking = true;
    try {
      this.port = port;
      await this.opens();
      this.found();
    } finally {
      this.looking = false;
    }
  }

  async close(): Promise<void> {
    this.isOver = true;
    clearInterval(this.timer);
    serial?.removeEventListener("connect", this.looks);
    serial?.removeEventListener("disconnect", this.looks);
    await this.letGo();
  }

  private async letGo(): Promise<void> {
    const { reader, writer } = this;
    this.reader = this.writer = null;
    try {
      await reader?.cancel();
      reader?.releaseLock();
      await writer?.close();
    } catch {
      // It is gone.
    }
    await this.port.close().catch(() => {});
  }

  private async opens(): Promise<void> {
    try {
      await this.port.open(LINE);
    } catch (error) {
      throw (error as DOMException).name === "NotFoundError" ? PORT_GONE : PORT_BUSY;
    }
    // As every other program of the arm has them; adapters without them work as well.
    await this.port.setSignals?.({ dataTerminalReady: true, requestToSend: true }).catch(() => {});
    this.writer = this.port.writable?.getWriter() ?? null;
    const ports = (await serial?.getPorts()) ?? [];
    this.others = ports.filter((port) => port !== this.port);
  }

  /** Reads until the port is gone. Noise, a break, an overrun end a stream, not the port: it has another one then. */
  private async pump(): Promise<void> {
    const { port } = this;
    for (let errors = 0; !this.isOver && this.writer !== null && port.readable !== null && errors < ERRORS; ) {
      const reader = port.readable.getReader();
      this.reader = reader;
      try {
        for (;;) {
          const { value, done } = await reader.read();
          if (done) break;
          errors = 0;
          this.ends?.heard(value);
        }
        errors++;
      } catch {
        errors++;
      } finally {
        reader.releaseLock();
      }
    }
    this.lost();
  }

  private lost(): void {
    if (this.isOver || this.writer === null) return;
    this.writer = null;
    this.ends?.is(false);
    void this.letGo();
    this.timer = setInterval(this.looks, LOOK);
  }

  private found(): void {
    clearInterval(this.timer);
    this.ends?.is(true);
    void this.pump();
  }

  /** Is it there still, or again? */
  private async look(): Promise<void> {
    if (this.isOver || this.looking) return;
    this.looking = true;
    try {
      const ports = (await serial?.getPorts()) ?? [];
      if (this.writer !== null) {
        if (this.port.connected === false || !ports.includes(this.port)) this.lost();
        return;
      }
      const there = ports.filter((port) => port.connected !== false && kind(port) === kind(this.port));
      const mine = there.includes(this.port) ? [this.port] : there.filter((port) => !this.others.includes(port));
      // Of two that came, none is sure to be it.
      const [port, another] = mine;
      if (port === undefined || another !== undefined) return;
      this.port = port;
      await this.opens();
      this.found();
    } catch {
      // Not yet.
    } finally {
      this.looking = false;
    }
  }
}
