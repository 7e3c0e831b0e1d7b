// Scroll positions: a new route opens at its top, and going back restores the earlier position.

const positions = new Map<number, number>();
let entry = entryNumber(history.state);
/** Position to scroll to once the route is rendered. */
let wantedPosition: number | null = null;
let next: ReturnType<typeof setTimeout> | undefined;

function entryNumber(state: unknown): number {
  const known = (state as { entry?: number } | null)?.entry;
  if (known !== undefined) return known;
  const made = Date.now() + Math.random();
  history.replaceState({ ...(history.state as object | null), entry: made }, "");
  return made;
}

/** Follows the browser history. */
export function followHistory(): void {
  history.scrollRestoration = "manual";
  addEventListener("scroll", () => wantedPosition === null && positions.set(entry, scrollY), { passive: true });
  addEventListener("popstate", ({ state }: PopStateEvent) => {
    clearTimeout(next);
    entry = entryNumber(state);
    wantedPosition = positions.get(entry) ?? 0;
    scrollTo(0, 0);
  });
  // Scrolling by the user takes precedence.
  for (const event of ["wheel", "touchmove", "keydown"])
    addEventListener(event, () => (wantedPosition = null), { passive: true });
}

/**
 * Called after the route is rendered. Its height still changes for a moment, so the position is set
 * again until it is stable or `tries` run out.
 */
export function restoreScroll(tries = 30): void {
  const { style } = document.documentElement;
  if (wantedPosition === null || tries === 0 || wantedPosition === 0) {
    style.overflowAnchor = "";
    wantedPosition = null;
    return;
  }
  // The browser's scroll anchoring would move the page to keep visible elements in place.
  style.overflowAnchor = "none";
  if (Math.abs(scrollY - wantedPosition) > 1) scrollTo(0, wantedPosition);
  next = setTimeout(() => restoreScroll(tries - 1), 50);
}
