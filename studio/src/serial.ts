// Serial line to a real arm: a port of the browser, opened in the worker. A lost port is searched
// for and reopened.
import { PORT_BUSY, PORT_GONE } from "./carrier";

/** Undefined in browsers without Web Serial. */
export const serial: Serial | undefined = navigator.serial;

/** USB adapters used in arms: CP210x, CH340, CH9102, Arduino. */
const FILTERS = [
  { usbVendorId: 0x10c4, usbProductId: 0xea60 },
  { usbVendorId: 0x1a86, usbProductId: 0x7523 },
  { usbVendorId: 0x1a86, usbProductId: 0x55d4 },
  { usbVendorId: 0x2341 },
];
/** Line settings. 8N1 without flow control is the browsers' default. */
const LINE = { baudRate: 115200, bufferSize: 16384 };
/**
 * Interval at which a lost port is searched for, ms. A browser may miss the `connect` event, so the
 * worker polls as well.
 */
const LOOK = 500;
/**
 * Number of consecutive stream errors without a byte in between that mean a lost port instead of
 * noise. A choice.
 */
const ERRORS = 100;

const kind = (port: SerialPort) => `${port.getInfo().usbVendorId}:${port.getInfo().usbProductId}`;

/**
 * Asks the user for a port, in the window. Returns its index among the permitted ports, for the
 * worker; null if the user chose no port.
 */
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

/** Chosen port if it is still present. */
async function portOf(chosen: string): Promise<SerialPort> {
  const [at = "", of] = chosen.split(" ");
  const port = (await serial?.getPorts())?.[Number(at)];
  if (port === undefined || kind(port) !== of) throw PORT_GONE;
  return port;
}

/** Receiver of the line's bytes and state. */
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
  /**
   * Other ports of the same kind while this one was present: after a loss a reappearing port cannot
   * be one of these.
   */
  private others: SerialPort[] = [];
  private looking = false;

  private constructor(private port: SerialPort) {}

  /** Opens a port as encoded by `choose`. Throws a code of `closed`. */
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
    // Bytes written to a broken line are lost: the driver does not send them twice.
    this.writer?.write(bytes).catch(() => this.lost());
  }

  /** Reopens a lost line at the port that the user has chosen, which may be another one. */
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
      // The port is gone already.
    }
    await this.port.close().catch(() => {});
  }

  private async opens(): Promise<void> {
    try {
      await this.port.open(LINE);
    } catch (error) {
      throw (error as DOMException).name === "NotFoundError" ? PORT_GONE : PORT_BUSY;
    }
    // Every other program of the arm sets these signals. Adapters without them work as well.
    await this.port.setSignals?.({ dataTerminalReady: true, requestToSend: true }).catch(() => {});
    this.writer = this.port.writable?.getWriter() ?? null;
    const ports = (await serial?.getPorts()) ?? [];
    this.others = ports.filter((port) => port !== this.port);
  }

  /**
   * Reads until the port is gone. Noise, a break or an overrun ends a stream but not the port,
   * which then supplies a new one.
   */
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

  /** Checks if the port is still present or has reappeared. */
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
      // With two new ports it is unknown which of them is the arm's.
      const [port, another] = mine;
      if (port === undefined || another !== undefined) return;
      this.port = port;
      await this.opens();
      this.found();
    } catch {
      // Not yet present.
    } finally {
      this.looking = false;
    }
  }
}
