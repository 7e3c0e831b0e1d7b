// Where a page opens: a route at its top, and one that is gone back to where it was left.

const places = new Map<number, number>();
let entry = numberOf(history.state);
/** Where the page is to be scrolled to once its route is painted. */
let wanted: number | null = null;
let next: ReturnType<typeof setTimeout> | undefined;

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
    clearTimeout(next);
    entry = numberOf(state);
    wanted = places.get(entry) ?? 0;
    scrollTo(0, 0);
  });
  // A hand that scrolls meanwhile knows better.
  for (const event of ["wheel", "touchmove", "keydown"])
    addEventListener(event, () => (wanted = null), { passive: true });
}

/** The route is painted. What it shows still grows for a moment, and the place is held until it does not. */
export function painted(tries = 30): void {
  const { style } = document.documentElement;
  if (wanted === null || tries === 0 || wanted === 0) {
    style.overflowAnchor = "";
    wanted = null;
    return;
  }
  // The browser would hold what happens to be in sight.
  style.overflowAnchor = "none";
  if (Math.abs(scrollY - wanted) > 1) scrollTo(0, wanted);
  next = setTimeout(() => painted(tries - 1), 50);
}
