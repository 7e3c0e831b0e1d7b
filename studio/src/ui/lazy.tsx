// Parts of the page in files of their own, loaded on demand.
import { signal } from "@preact/signals";
import type { ComponentType } from "preact";

/**
 * Component loaded once `wants` is true, and kept from then on. `failed` receives the error if the
 * file cannot be loaded.
 */
export function lazy(
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
