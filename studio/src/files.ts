// Files other than plans are read by another module in another worker, so that the worker with the
// arm can receive a stop meanwhile.

/**
 * Time after which a reader without an answer is terminated, ms. The station's own timeout is
 * longer.
 */
const READ_TIMEOUT = 60_000;
/**
 * File size from which on the worker is terminated afterwards, bytes: a WebAssembly memory never
 * shrinks.
 */
const LARGE_FILE = 4_000_000;

export class FilesWorker {
  private worker: Worker | null = null;
  /** Id of the file being read. The station requests one at a time. */
  private id: number | null = null;
  private isLarge = false;
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly module: URL,
    private readonly done: (id: number, answer: Uint8Array) => void,
  ) {}

  /** Handles a request of the station: id and content of a file, or the id alone to cancel it. */
  read(asked: Uint8Array): void {
    const id = new DataView(asked.buffer, asked.byteOffset).getUint32(0, true);
    if (asked.length === 4) {
      if (this.id === id) this.end();
      return;
    }
    this.end(this.id !== null);
    this.id = id;
    this.timer = setTimeout(() => this.answer(null), READ_TIMEOUT);
    const request = asked.slice(4);
    this.isLarge = request.length > LARGE_FILE;
    this.worker ??= this.ensureWorker();
    this.worker.postMessage({ module: this.module.href, request }, [request.buffer]);
  }

  private ensureWorker(): Worker {
    const worker = new Worker(new URL("./reader.ts", import.meta.url), { type: "module" });
    worker.onmessage = ({ data }: MessageEvent<Uint8Array | null>) => this.answer(data);
    worker.onerror = () => this.answer(null);
    return worker;
  }

  private answer(answer: Uint8Array | null): void {
    const id = this.id;
    this.end(answer === null || this.isLarge);
    if (id !== null) this.done(id, answer ?? new Uint8Array());
  }

  /** Ends the current file. A reader that failed or timed out is not used again. */
  private end(withWorker = true): void {
    clearTimeout(this.timer);
    this.id = null;
    if (!withWorker) return;
    this.worker?.terminate();
    this.worker = null;
  }
}
