// Jobs of this page that can only begin again: nothing says how far they came.
import { signal } from "@preact/signals";
import type { Job } from "../api";
import { RpcError } from "../client";
import type { Order } from "./jobs";

/** As many orders are kept. */
const MOST = 8;
/** How the station begins to say that a job cannot go on. */
const NOTHING = "nothing to resume";

interface Ordered {
  order: Order;
  title: string;
}
const orders = new Map<string, Ordered>();
const lost = signal<ReadonlySet<string>>(new Set());

/** Keeps what a job was started with. */
export function keepOrder(id: string, order: Order, title: string): void {
  orders.set(id, { order, title });
  for (const old of [...orders.keys()].slice(0, -MOST)) orders.delete(old);
}

/** Hears why a job was not resumed. */
export function hearRefusal(id: string, error: unknown): void {
  const said = error instanceof RpcError ? String(error.data.template ?? error.message) : "";
  if (said.startsWith(NOTHING)) lost.value = new Set([...lost.peek(), id]);
}

/** What a job was started with that cannot be resumed; null for one that can, or of another page. */
export const orderOf = ({ job }: Job): Ordered | null => (lost.value.has(job) ? (orders.get(job) ?? null) : null);
