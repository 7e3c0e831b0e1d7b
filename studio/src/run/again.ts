// Jobs of this page that can only be restarted, because no journal has their progress.
import { signal } from "@preact/signals";
import type { Job } from "../api";
import { RpcError } from "../client";
import type { Order } from "./jobs";

/** Largest number of orders kept. */
const MOST = 8;
/** Code of the refusal to resume a job without a journal. */
const NOTHING = "nothing-to-resume";

interface Ordered {
  order: Order;
  title: string;
}
const orders = new Map<string, Ordered>();
const lost = signal<ReadonlySet<string>>(new Set());

/** Stores the order of a job. */
export function keepOrder(id: string, order: Order, title: string): void {
  orders.set(id, { order, title });
  for (const old of [...orders.keys()].slice(0, -MOST)) orders.delete(old);
}

/** Notes why a resume was refused. */
export function hearRefusal(id: string, error: unknown): void {
  if (error instanceof RpcError && error.data.code === NOTHING) lost.value = new Set([...lost.peek(), id]);
}

/** Order of a job that cannot be resumed; null if it can, or if another page started it. */
export const orderOf = ({ job }: Job): Ordered | null => (lost.value.has(job) ? (orders.get(job) ?? null) : null);
