// Library of the virtual arm's station, stored in the browser (OPFS), because the module has it in
// memory only.
import type { RpcMessage } from "./messages";

const FOLDER = "programs";

type Folder = FileSystemDirectoryHandle & AsyncIterable<[string, FileSystemHandle]>;

/**
 * Requested change of the library. It is stored once the station has confirmed it, with the
 * station's content.
 */
type Change = { fetch: string } | { remove: string };

/** A preset is a file beside the programs, under a name that no program can have. */
const presetFile = (name: string) => `preset+${name}.toml`;

export class StoredLibrary {
  private readonly requests = new Map<string, Change>();
  private work: Promise<unknown> = Promise.resolve();

  private constructor(private readonly folder: Folder | null) {}

  static async open(): Promise<StoredLibrary> {
    try {
      const root = await navigator.storage.getDirectory();
      return new StoredLibrary((await root.getDirectoryHandle(FOLDER, { create: true })) as Folder);
    } catch {
      // Private windows offer no storage.
      return new StoredLibrary(null);
    }
  }

  async *all(): AsyncGenerator<[string, Uint8Array]> {
    if (this.folder === null) return;
    for await (const [name, handle] of this.folder) {
      if (handle.kind !== "file") continue;
      yield [name, new Uint8Array(await (await (handle as FileSystemFileHandle).getFile()).arrayBuffer())];
    }
  }

  /** Notes the request of a session if it changes the library. */
  onRequest(session: number, { id, method, params }: RpcMessage): void {
    const { name = "", to = "" } = (params ?? {}) as Record<string, string>;
    const changes: Record<string, Change> = {
      "program.put": { fetch: name },
      "program.convert": { fetch: to },
      "program.delete": { remove: name },
      "preset.save": { fetch: presetFile(name) },
      "preset.remove": { remove: presetFile(name) },
    };
    const change = changes[method ?? ""];
    if (this.folder !== null && id != null && change !== undefined) this.requests.set(`${session} ${id}`, change);
  }

  /** Handles the answer to such a request, and stores the content that `get` returns. */
  onAnswer(session: number, message: RpcMessage, get: (name: string) => Uint8Array | null): void {
    if (message.method !== undefined) return;
    const key = `${session} ${message.id}`;
    const change = this.requests.get(key);
    this.requests.delete(key);
    if (change === undefined || message.error) return;
    if ("remove" in change) {
      this.enqueue((folder) => folder.removeEntry(change.remove));
    } else {
      const made = get(change.fetch);
      if (made !== null) this.write(change.fetch, made);
    }
  }

  write(name: string, bytes: Uint8Array): void {
    this.enqueue(async (folder) => {
      const handle = await folder.getFileHandle(name, { create: true });
      const access = await handle.createSyncAccessHandle();
      access.truncate(0);
      access.write(bytes);
      access.flush();
      access.close();
    });
  }

  /**
   * Runs storage operations one after the other. If the storage refuses one, the change lasts until
   * the page is closed.
   */
  private enqueue(work: (folder: Folder) => Promise<unknown>): void {
    const { folder } = this;
    if (folder !== null) this.work = this.work.then(() => work(folder)).catch(() => {});
  }
}
