// Files that are no plans are read by another module in another worker: the worker that holds the arm hears a stop meanwhile.

/** A reader that has not answered by then is ended, ms. The station gives up later. */
const LONGEST = 60_000;
/** The memory of a module does not shrink: behind a file as large as this its worker goes. */
const LARGE = 4_000_000;

export class FilesWorker {
  private worker: Worker | null = null;
  /** The file that is being read: the station asks for one at a time. */
  private id: number | null = null;
  private isLarge = false;
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly module: URL,
    private readonly done: (id: number, answer: Uint8Array) => void,
  ) {}

  /** What the station asks for: the id of a file, and the file, or none if it is wanted no more. */
  read(asked: Uint8Array): void {
    const id = new DataView(asked.buffer, asked.byteOffset).getUint32(0, true);
    if (asked.length === 4) {
      if (this.id === id) this.end();
      return;
    }
    this.end(this.id !== null);
    this.id = id;
    this.timer = setTimeout(() => this.answer(null), LONGEST);
    const request = asked.slice(4);
    this.isLarge = request.length > LARGE;
    this.worker ??= this.made();
    this.worker.postMessage({ module: this.module.href, request }, [request.buffer]);
  }

  private made(): Worker {
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

  /** No file is being read. A reader that was given up on, or that failed, is not asked again. */
  private end(withWorker = true): void {
    clearTimeout(this.timer);
    this.id = null;
    if (!withWorker) return;
    this.worker?.terminate();
    this.worker = null;
  }
}
