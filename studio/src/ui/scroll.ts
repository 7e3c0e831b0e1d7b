// Scroll positions: a new route opens at its top, and going back restores the earlier position.

const places = new Map<number, number>();
let entry = numberOf(history.state);
/** Position to scroll to once the route is rendered. */
let wanted: number | null = null;
let next: ReturnType<typeof setTimeout> | undefined;

function numberOf(state: unknown): number {
  const known = (state as { entry?: number } | null)?.entry;
  if (known !== undefined) return known;
  const made = Date.now() + Math.random();
  history.replaceState({ ...(history.state as object | null), entry: made }, "");
  return made;
}

/** Follows the browser history. */
export function keepPlaces(): void {
  history.scrollRestoration = "manual";
  addEventListener("scroll", () => wanted === null && places.set(entry, scrollY), { passive: true });
  addEventListener("popstate", ({ state }: PopStateEvent) => {
    clearTimeout(next);
    entry = numberOf(state);
    wanted = places.get(entry) ?? 0;
    scrollTo(0, 0);
  });
  // Scrolling by the user takes precedence.
  for (const event of ["wheel", "touchmove", "keydown"])
    addEventListener(event, () => (wanted = null), { passive: true });
}

/**
 * Called after the route is rendered. Its height still changes for a moment, so the position is set
 * again until it is stable or `tries` run out.
 */
export function painted(tries = 30): void {
  const { style } = document.documentElement;
  if (wanted === null || tries === 0 || wanted === 0) {
    style.overflowAnchor = "";
    wanted = null;
    return;
  }
  // The browser's scroll anchoring would move the page to keep visible elements in place.
  style.overflowAnchor = "none";
  if (Math.abs(scrollY - wanted) > 1) scrollTo(0, wanted);
  next = setTimeout(() => painted(tries - 1), 50);
}
