// Parts of the page that come when they are wanted: each is a file of its own.
import { signal } from "@preact/signals";
import type { ComponentType } from "preact";

/** A part that comes after what stands around it, and stays; `wants` says from when on. */
export function later(load: () => Promise<ComponentType>, wants = () => true): ComponentType {
  const part = signal<ComponentType | null>(null);
  let isAsked = false;
  return () => {
    const Shown = part.value;
    if (Shown !== null) return <Shown />;
    if (wants() && !isAsked) {
      isAsked = true;
      load().then(
        (loaded) => (part.value = loaded),
        () => (isAsked = false),
      );
    }
    return null;
  };
}
