// Parts of the page that come when they are wanted: each is a file of its own.
import { signal } from "@preact/signals";
import type { ComponentType } from "preact";

/** A part that comes after what stands around it, and stays; `wants` says from when on, `failed` hears why it did not come. */
export function later(
  load: () => Promise<ComponentType>,
  wants = () => true,
  failed: (error: unknown) => void = () => {},
): ComponentType {
  const part = signal<ComponentType | null>(null);
  let isAsked = false;
  return () => {
    const Shown = part.value;
    if (Shown !== null) return <Shown />;
    if (wants() && !isAsked) {
      isAsked = true;
      load().then(
        (loaded) => (part.value = loaded),
        (error: unknown) => {
          isAsked = false;
          failed(error);
        },
      );
    }
    return null;
  };
}
