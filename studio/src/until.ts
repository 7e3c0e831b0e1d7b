import { effect } from "@preact/signals";

/** Waits until what signals say is so; false if it is not so within a time, ms. */
export function until(is: () => boolean, within?: number): Promise<boolean> {
  return new Promise((done) => {
    const ended = (found: boolean) => {
      clearTimeout(late);
      // The effect may be running for the first time, and has no end yet.
      queueMicrotask(() => end());
      done(found);
    };
    const late = within === undefined ? undefined : setTimeout(() => ended(false), within);
    const end = effect(() => {
      if (is()) ended(true);
    });
  });
}
