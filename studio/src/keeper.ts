// Keeps a held jog alive in the worker. The page's main thread may be busy for a moment, but a jog
// must end if it hangs.
import type { RpcMessage } from "./messages";

/**
 * Silence of the main thread after which it counts as hung, ms, because the user could not release
 * the button. With one more interval the arm stands 300 ms after the thread hung.
 */
const HANG_TIMEOUT = 230;

export class JogKeeper {
  private id: number | null = null;
  private arm: Record<string, unknown> = {};
  private jog: string | null = null;
  private released = false;
  private timer: ReturnType<typeof setInterval> | undefined;
  private keptAliveAt = 0;
  private timeout = 0;
  private aliveAt = 0;

  constructor(private readonly send: (message: RpcMessage) => void) {}

  start(message: RpcMessage, every: number, most: number): void {
    this.release();
    this.id = message.id ?? null;
    const arm = message.params?.arm;
    this.arm = arm === undefined ? {} : { arm };
    this.jog = null;
    this.released = false;
    this.aliveAt = performance.now();
    this.timeout = most;
    this.send(message);
    this.timer = setInterval(() => this.tick(), every);
  }

  /**
   * Ends the jog. If its start has not been answered yet (the arm comes to rest first), it will not
   * begin.
   */
  release(): void {
    clearInterval(this.timer);
    this.timer = undefined;
    if (this.released) return;
    this.released = true;
    if (this.jog !== null) this.stop({ jog: this.jog });
    else if (this.id !== null) this.stop(this.arm);
    this.jog = null;
  }

  noteAlive(): void {
    this.aliveAt = performance.now();
  }

  /** Handles a message of the station. */
  onMessage(message: RpcMessage): void {
    if (message.id !== undefined && message.id === this.id) {
      this.id = null;
      const jog = (message.result as { jog?: string } | undefined)?.jog;
      if (jog === undefined) {
        clearInterval(this.timer);
        this.released = true;
      } else if (this.released) {
        // The jog started before its stop arrived.
        this.stop({ jog });
      } else {
        this.jog = jog;
        this.keptAliveAt = performance.now();
        // The arm may have taken a while to begin.
        this.tick();
      }
    } else if (message.method === "jog.ended" && message.params?.jog === this.jog) {
      clearInterval(this.timer);
      this.jog = null;
      this.released = true;
    }
  }

  private tick(): void {
    const now = performance.now();
    // After the computer slept, the jog has ended by itself and must not be renewed by the old
    // hold.
    const slept = this.jog !== null && now - this.keptAliveAt > this.timeout;
    if (slept || now - this.aliveAt > HANG_TIMEOUT) {
      this.release();
    } else if (this.jog !== null) {
      this.keptAliveAt = now;
      this.send({ jsonrpc: "2.0", method: "jog.keep", params: { jog: this.jog } });
    }
  }

  private stop(params: Record<string, unknown>): void {
    this.send({ jsonrpc: "2.0", method: "jog.stop", params });
  }
}
