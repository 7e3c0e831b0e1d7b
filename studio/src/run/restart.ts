// Jobs of this page that can only be restarted, because no journal has their progress.
import { signal } from "@preact/signals";
import type { Job } from "../api";
import { RpcError } from "../client";
import type { Order } from "./jobs";

/** Largest number of orders kept. */
const MAX_ORDERS = 8;
/** Code of the refusal to resume a job without a journal. */
const NOTHING_TO_RESUME = "nothing-to-resume";

interface StoredOrder {
  order: Order;
  title: string;
}
const orders = new Map<string, StoredOrder>();
const unresumableJobs = signal<ReadonlySet<string>>(new Set());

/** Stores the order of a job. */
export function storeOrder(id: string, order: Order, title: string): void {
  orders.set(id, { order, title });
  for (const old of [...orders.keys()].slice(0, -MAX_ORDERS)) orders.delete(old);
}

/** Notes why a resume was refused. */
export function noteRefusal(id: string, error: unknown): void {
  if (error instanceof RpcError && error.data.code === NOTHING_TO_RESUME)
    unresumableJobs.value = new Set([...unresumableJobs.peek(), id]);
}

/** Order of a job that cannot be resumed; null if it can, or if another page started it. */
export const restartOrder = ({ job }: Job): StoredOrder | null =>
  unresumableJobs.value.has(job) ? (orders.get(job) ?? null) : null;
