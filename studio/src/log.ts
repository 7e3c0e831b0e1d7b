// Log of events for people, shown in `#/arms`.
import { signal } from "@preact/signals";

const MAX_LINES = 500;

export const lines = signal<Array<{ at: Date; text: string }>>([]);

export function log(text: string): void {
  lines.value = [...lines.value.slice(1 - MAX_LINES), { at: new Date(), text }];
}

export const clock = (at: Date): string => at.toLocaleTimeString("en-GB");

export function save(name: string, content: BlobPart, type = "text/plain"): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([content], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
