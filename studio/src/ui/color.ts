/** The colour that a custom property of the page comes to at an element, for what is not drawn by CSS: `light-dark()` is resolved. */
export function colorAt(element: Element, property: string): string {
  const probe = document.createElement("i");
  probe.style.color = `var(${property})`;
  element.append(probe);
  const { color } = getComputedStyle(probe);
  probe.remove();
  return color;
}
