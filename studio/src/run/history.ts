// Undo and redo.
import { computed, signal } from "@preact/signals";

/** Largest number of undo steps. */
const MAX_STEPS = 100;

export class History<T> {
  readonly now;
  private readonly past = signal<readonly T[]>([]);
  private readonly future = signal<readonly T[]>([]);
  private key: string | null = null;
  readonly canUndo = computed(() => this.past.value.length > 0);
  readonly canRedo = computed(() => this.future.value.length > 0);

  constructor(first: T) {
    this.now = signal(first);
  }

  /**
   * Sets a new state. Consecutive changes with the same key, such as letters of a text, are undone
   * together.
   */
  commit(next: T, key: string | null = null): void {
    if (key === null || key !== this.key) this.past.value = [...this.past.value, this.now.value].slice(-MAX_STEPS);
    this.key = key;
    this.future.value = [];
    this.now.value = next;
  }

  /** Changes the state without an undo step, for changes that the user did not make. */
  amend(next: T): void {
    this.now.value = next;
  }

  /** Starts a new undo step with the next change. */
  seal(): void {
    this.key = null;
  }

  undo(): void {
    const before = this.past.value.at(-1);
    if (before === undefined) return;
    this.past.value = this.past.value.slice(0, -1);
    this.future.value = [this.now.value, ...this.future.value];
    this.now.value = before;
    this.seal();
  }

  redo(): void {
    const [next, ...rest] = this.future.value;
    if (next === undefined) return;
    this.future.value = rest;
    this.past.value = [...this.past.value, this.now.value];
    this.now.value = next;
    this.seal();
  }
}
