// Where a page opens: a route at its top, and one that is gone back to where it was left.

const places = new Map<number, number>();
let entry = numberOf(history.state);
/** Where the page is to be scrolled to once its route is painted. */
let wanted: number | null = null;

function numberOf(state: unknown): number {
  const known = (state as { entry?: number } | null)?.entry;
  if (known !== undefined) return known;
  const made = Date.now() + Math.random();
  history.replaceState({ ...(history.state as object | null), entry: made }, "");
  return made;
}

/** Follows the history of the page. */
export function keepPlaces(): void {
  history.scrollRestoration = "manual";
  addEventListener("scroll", () => wanted === null && places.set(entry, scrollY), { passive: true });
  addEventListener("popstate", ({ state }: PopStateEvent) => {
    entry = numberOf(state);
    wanted = places.get(entry) ?? 0;
    scrollTo(0, 0);
  });
  // A hand that scrolls meanwhile knows better.
  for (const event of ["wheel", "touchmove", "keydown"])
    addEventListener(event, () => (wanted = null), { passive: true });
}

/** The route is painted: what it shows may still grow, and is waited for a moment. */
export function painted(tries = 80): void {
  if (wanted === null) return;
  scrollTo(0, wanted);
  if (tries > 0 && scrollY < wanted - 1) return void setTimeout(() => painted(tries - 1), 50);
  wanted = null;
}
