// What a person can undo and redo.
import { computed, signal } from "@preact/signals";

/** As many steps back are kept. */
const MOST = 100;

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

  /** Goes on to another state. Changes of the same key in a row, such as the letters of a text, are undone together. */
  commit(next: T, key: string | null = null): void {
    if (key === null || key !== this.key) this.past.value = [...this.past.value, this.now.value].slice(-MOST);
    this.key = key;
    this.future.value = [];
    this.now.value = next;
  }

  /** Changes the state without a step to undo: what no person has done. */
  amend(next: T): void {
    this.now.value = next;
  }

  /** What comes next is undone by itself. */
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
