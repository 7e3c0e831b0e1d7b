// Transform of points from the plane of the sheet to pictures for a reader who stands in front of
// the arm: its base is at the top, +y points right, and x points down. All pictures use this one
// transform.
export type Points = ReadonlyArray<readonly number[]>;

/** Box in the arm's x and y, mm: `width` along x, `height` along y. */
export interface Frame {
  x: number;
  y: number;
  width: number;
  height: number;
}

/** Transform from the arm's x and y to the picture's. */
export const READER = "matrix(0 1 1 0 0 0)";
/**
 * Direction of text that is upright for the reader, degrees counter-clockwise from the arm's x
 * axis.
 */
export const UPRIGHT = 90;

/** Bounding box of points, with a margin. */
export function boundsOf(points: Points, room = 0): Frame {
  let [left, right, bottom, top] = [Infinity, -Infinity, Infinity, -Infinity];
  for (const [x = 0, y = 0] of points) {
    [left, right] = [Math.min(left, x), Math.max(right, x)];
    [bottom, top] = [Math.min(bottom, y), Math.max(top, y)];
  }
  if (left > right) return { x: 0, y: 0, width: 0, height: 0 };
  return { x: left - room, y: bottom - room, width: right - left + 2 * room, height: top - bottom + 2 * room };
}

/** SVG path data of a line. A single point is a line of zero length. */
export const pathOf = (points: Points): string =>
  `M${points.map(([x = 0, y = 0]) => `${x} ${y}`).join("L")}${points.length === 1 ? "h0" : ""}`;

/** SVG view box of a frame as the reader sees it. */
export const viewBox = ({ x, y, width, height }: Frame): string => `${y} ${x} ${height} ${width}`;
/** Aspect ratio of that picture, width divided by height. */
export const ratioOf = ({ width, height }: Frame): number => height / width;

/** Turns a picture by the core, with the arm's x to the right and y up, to the reader. */
export function toReader(svg: string): string {
  const head = /^(?:<\?xml[^>]*\?>\s*)?<svg\b([^>]*)>/.exec(svg);
  const box = /viewBox="([^"]*)"/
    .exec(head?.[1] ?? "")?.[1]
    ?.trim()
    .split(/[\s,]+/)
    .map(Number);
  if (head === null || box?.length !== 4 || !box.every(Number.isFinite)) return svg;
  const [x = 0, y = 0, width = 0, height = 0] = box;
  const sizes = [...(head[1] ?? "").matchAll(/\s(width|height)="([^"]*)"/g)].map(([, name, value]) => [name, value]);
  const { width: wide, height: high } = Object.fromEntries(sizes) as Record<string, string>;
  const size = wide !== undefined && high !== undefined ? ` width="${high}" height="${wide}"` : "";
  const inner = svg.slice(head[0].length, svg.lastIndexOf("</svg>"));
  const rest = (head[1] ?? "").replace(/\s(?:width|height|viewBox)="[^"]*"/g, "");
  return `<svg${rest}${size} viewBox="0 0 ${height} ${width}"><g transform="matrix(0 1 -1 0 ${y + height} ${-x})">${inner}</g></svg>\n`;
}
