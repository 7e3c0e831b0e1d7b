import { effect } from "@preact/signals";

/** Waits until a condition on signals is true; false if it is not within a time, ms. */
export function until(is: () => boolean, within?: number): Promise<boolean> {
  return new Promise((done) => {
    const ended = (found: boolean) => {
      clearTimeout(late);
      // On the effect's first run `end` is not assigned yet.
      queueMicrotask(() => end());
      done(found);
    };
    const late = within === undefined ? undefined : setTimeout(() => ended(false), within);
    const end = effect(() => {
      if (is()) ended(true);
    });
  });
}
