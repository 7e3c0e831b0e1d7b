/**
 * Computed colour of a custom property at an element, with `light-dark()` resolved, for drawings
 * that do not use CSS.
 */
export function colorAt(element: Element, property: string): string {
  const probe = document.createElement("i");
  probe.style.color = `var(${property})`;
  element.append(probe);
  const { color } = getComputedStyle(probe);
  probe.remove();
  return color;
}
