// Serial line to a real arm: a port of the browser, opened in the worker. A lost port is searched
// for and reopened.
import { PORT_BUSY, PORT_GONE } from "./messages";

/** Undefined in browsers without Web Serial. */
export const serial: Serial | undefined = navigator.serial;

/** USB adapters used in arms: CP210x, CH340, CH9102, Arduino. */
const ADAPTER_FILTERS = [
  { usbVendorId: 0x10c4, usbProductId: 0xea60 },
  { usbVendorId: 0x1a86, usbProductId: 0x7523 },
  { usbVendorId: 0x1a86, usbProductId: 0x55d4 },
  { usbVendorId: 0x2341 },
];
/** Line settings. 8N1 without flow control is the browsers' default. */
const LINE_SETTINGS = { baudRate: 115200, bufferSize: 16384 };
/**
 * Interval at which a lost port is searched for, ms. A browser may miss the `connect` event, so the
 * worker polls as well.
 */
const SEARCH_INTERVAL = 500;
/**
 * Number of consecutive stream errors without a byte in between that mean a lost port instead of
 * noise. A choice.
 */
const MAX_STREAM_ERRORS = 100;

const adapterKind = (port: SerialPort) => `${port.getInfo().usbVendorId}:${port.getInfo().usbProductId}`;

/**
 * Asks the user for a port, in the window. Returns its index among the permitted ports, for the
 * worker; null if the user chose no port.
 */
export async function choosePort(): Promise<string | null> {
  if (serial === undefined) return null;
  let port: SerialPort;
  try {
    port = await serial.requestPort({ filters: ADAPTER_FILTERS });
  } catch (error) {
    if ((error as DOMException).name === "NotFoundError") return null;
    throw error;
  }
  return `${(await serial.getPorts()).indexOf(port)} ${adapterKind(port)}`;
}

/** Chosen port if it is still present. */
async function portOf(chosen: string): Promise<SerialPort> {
  const [at = "", of] = chosen.split(" ");
  const port = (await serial?.getPorts())?.[Number(at)];
  if (port === undefined || adapterKind(port) !== of) throw PORT_GONE;
  return port;
}

/** Receiver of the line's bytes and state. */
interface LineReceiver {
  receive(bytes: Uint8Array): void;
  setPresent(there: boolean): void;
}

export class SerialLine {
  private writer: WritableStreamDefaultWriter<Uint8Array> | null = null;
  private reader: ReadableStreamDefaultReader<Uint8Array> | null = null;
  private receiver: LineReceiver | null = null;
  private timer: ReturnType<typeof setInterval> | undefined;
  private readonly onPortChange = () => void this.checkPort();
  private isClosed = false;
  /**
   * Other ports of the same kind while this one was present: after a loss a reappearing port cannot
   * be one of these.
   */
  private otherPorts: SerialPort[] = [];
  private isSearching = false;

  private constructor(private port: SerialPort) {}

  /** Opens a port as encoded by `choosePort`. Throws a code of `closed`. */
  static async open(chosen: string): Promise<SerialLine> {
    const line = new SerialLine(await portOf(chosen));
    await line.openPort();
    return line;
  }

  start(ends: LineReceiver): void {
    this.receiver = ends;
    serial?.addEventListener("connect", this.onPortChange);
    serial?.addEventListener("disconnect", this.onPortChange);
    void this.pump();
  }

  write(bytes: Uint8Array): void {
    // Bytes written to a broken line are lost: the driver does not send them twice.
    this.writer?.write(bytes).catch(() => this.onLost());
  }

  /** Reopens a lost line at the port that the user has chosen, which may be another one. */
  async reopen(chosen: string): Promise<void> {
    const port = await portOf(chosen);
    if (this.writer !== null || this.isSearching) return;
    this.isSearching = true;
    try {
      this.port = port;
      await this.openPort();
      this.onFound();
    } finally {
      this.isSearching = false;
    }
  }

  async close(): Promise<void> {
    this.isClosed = true;
    clearInterval(this.timer);
    serial?.removeEventListener("connect", this.onPortChange);
    serial?.removeEventListener("disconnect", this.onPortChange);
    await this.releasePort();
  }

  private async releasePort(): Promise<void> {
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

  private async openPort(): Promise<void> {
    try {
      await this.port.open(LINE_SETTINGS);
    } catch (error) {
      throw (error as DOMException).name === "NotFoundError" ? PORT_GONE : PORT_BUSY;
    }
    // Every other program of the arm sets these signals. Adapters without them work as well.
    await this.port.setSignals?.({ dataTerminalReady: true, requestToSend: true }).catch(() => {});
    this.writer = this.port.writable?.getWriter() ?? null;
    const ports = (await serial?.getPorts()) ?? [];
    this.otherPorts = ports.filter((port) => port !== this.port);
  }

  /**
   * Reads until the port is gone. Noise, a break or an overrun ends a stream but not the port,
   * which then supplies a new one.
   */
  private async pump(): Promise<void> {
    const { port } = this;
    for (
      let errors = 0;
      !this.isClosed && this.writer !== null && port.readable !== null && errors < MAX_STREAM_ERRORS;
    ) {
      const reader = port.readable.getReader();
      this.reader = reader;
      try {
        for (;;) {
          const { value, done } = await reader.read();
          if (done) break;
          errors = 0;
          this.receiver?.receive(value);
        }
        errors++;
      } catch {
        errors++;
      } finally {
        reader.releaseLock();
      }
    }
    this.onLost();
  }

  private onLost(): void {
    if (this.isClosed || this.writer === null) return;
    this.writer = null;
    this.receiver?.setPresent(false);
    void this.releasePort();
    this.timer = setInterval(this.onPortChange, SEARCH_INTERVAL);
  }

  private onFound(): void {
    clearInterval(this.timer);
    this.receiver?.setPresent(true);
    void this.pump();
  }

  /** Checks if the port is still present or has reappeared. */
  private async checkPort(): Promise<void> {
    if (this.isClosed || this.isSearching) return;
    this.isSearching = true;
    try {
      const ports = (await serial?.getPorts()) ?? [];
      if (this.writer !== null) {
        if (this.port.connected === false || !ports.includes(this.port)) this.onLost();
        return;
      }
      const there = ports.filter((port) => port.connected !== false && adapterKind(port) === adapterKind(this.port));
      const mine = there.includes(this.port) ? [this.port] : there.filter((port) => !this.otherPorts.includes(port));
      // With two new ports it is unknown which of them is the arm's.
      const [port, another] = mine;
      if (port === undefined || another !== undefined) return;
      this.port = port;
      await this.openPort();
      this.onFound();
    } catch {
      // Not yet present.
    } finally {
      this.isSearching = false;
    }
  }
}
