// Points in the plane of the sheet, as pictures of the page show them: to the reader who stands in front of the arm and looks at it.
// The arm's base is at the top, its +y is to the right, and its x runs down. This is the one place of that transform.
export type Points = ReadonlyArray<readonly number[]>;

/** A box in the arm's x and y, mm: `width` is along x, `height` along y. */
export interface Frame {
  x: number;
  y: number;
  width: number;
  height: number;
}

/** From the arm's x and y to the picture's. */
export const READER = "matrix(0 1 1 0 0 0)";
/** What lies so, in degrees from the arm's x counter-clockwise, is upright for the reader. */
export const UPRIGHT = 90;

/** What points fill, with room round it. */
export function boundsOf(points: Points, room = 0): Frame {
  let [left, right, bottom, top] = [Infinity, -Infinity, Infinity, -Infinity];
  for (const [x = 0, y = 0] of points) {
    [left, right] = [Math.min(left, x), Math.max(right, x)];
    [bottom, top] = [Math.min(bottom, y), Math.max(top, y)];
  }
  if (left > right) return { x: 0, y: 0, width: 0, height: 0 };
  return { x: left - room, y: bottom - room, width: right - left + 2 * room, height: top - bottom + 2 * room };
}

/** A line as the data of a path; a point is a line of no length. */
export const pathOf = (points: Points): string =>
  `M${points.map(([x = 0, y = 0]) => `${x} ${y}`).join("L")}${points.length === 1 ? "h0" : ""}`;

/** The view box of a picture that shows this frame to the reader. */
export const viewBox = ({ x, y, width, height }: Frame): string => `${y} ${x} ${height} ${width}`;
/** Width by height of that picture. */
export const ratioOf = ({ width, height }: Frame): number => height / width;

/** Turns a picture that has the arm's x to the right and y up, as the core writes it, to the reader. */
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
