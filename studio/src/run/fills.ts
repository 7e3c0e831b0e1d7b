// Detects filled shapes in a drawing: the pen outlines them unless filling is selected.

const SHAPE_ELEMENTS = ["path", "rect", "circle", "ellipse", "polygon"];
/** Elements whose content is not drawn directly. */
const HIDDEN_ELEMENTS = ["defs", "clipPath", "mask", "symbol", "pattern", "marker", "filter"];
const INVISIBLE_FILL = /^(?:none|transparent|white|#fff(?:fff)?|rgba\(.*,\s*0\))$/i;

const attribute = (attributes: string, name: string): string | undefined =>
  new RegExp(`(?:^|\\s)${name}\\s*=\\s*(?:"([^"]*)"|'([^']*)')`)
    .exec(attributes)
    ?.slice(1)
    .find((value) => value !== undefined);
const fillOfStyle = (style: string): string | undefined => /(?:^|[;{\s])fill\s*:\s*([^;}]+)/.exec(style)?.[1]?.trim();

/** Fills that style sheets assign to classes and elements. */
function styleFills(svg: string): Map<string, string> {
  const found = new Map<string, string>();
  for (const [, sheet = ""] of svg.matchAll(/<style[^>]*>([\s\S]*?)<\/style>/g)) {
    for (const [, selectors = "", body = ""] of sheet.matchAll(/([^{}]+)\{([^}]*)\}/g)) {
      const fill = fillOfStyle(body);
      if (fill !== undefined) for (const one of selectors.split(",")) found.set(one.trim(), fill);
    }
  }
  return found;
}

/** True if a shape of this SVG is filled with anything but white. */
export function hasFills(svg: string): boolean {
  const styles = styleFills(svg);
  const plain = svg.replace(/<!--[\s\S]*?-->|<style[\s\S]*?<\/style>|<!\[CDATA\[[\s\S]*?\]\]>/g, "");
  const open: Array<{ fill: string; hidden: boolean }> = [{ fill: "black", hidden: false }];
  for (const [, closing, tag = "", attributes = "", selfClosing] of plain.matchAll(
    /<(\/?)([A-Za-z][\w:-]*)((?:"[^"]*"|'[^']*'|[^"'>])*?)(\/?)>/g,
  )) {
    if (closing === "/") {
      if (open.length > 1) open.pop();
      continue;
    }
    const outer = open.at(-1) ?? { fill: "black", hidden: false };
    const classes = (attribute(attributes, "class") ?? "").split(/\s+/).map((name) => styles.get(`.${name}`));
    const fill =
      fillOfStyle(attribute(attributes, "style") ?? "") ??
      classes.findLast((one) => one !== undefined) ??
      styles.get(tag) ??
      attribute(attributes, "fill") ??
      outer.fill;
    const hidden = outer.hidden || HIDDEN_ELEMENTS.includes(tag) || attribute(attributes, "display") === "none";
    if (!hidden && SHAPE_ELEMENTS.includes(tag) && !INVISIBLE_FILL.test(fill.trim()) && isArea(tag, attributes))
      return true;
    if (selfClosing !== "/") open.push({ fill, hidden });
  }
  return false;
}

/** True if a shape has an area: a line of two points has none. */
function isArea(tag: string, attributes: string): boolean {
  const data = attribute(attributes, "d") ?? "";
  const numbers = data.match(/-?(?:\d+\.?\d*|\.\d+)/g)?.length ?? 0;
  return tag !== "path" || /[zcsqta]/i.test(data) || numbers > 4;
}
