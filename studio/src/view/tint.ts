// Colours of objects in the picture. Pure red, green and blue would be too bright beside a white
// arm.
const PALETTE: ReadonlyArray<readonly [upTo: number, color: string]> = [
  [18, "#d8544f"],
  [45, "#df8b3f"],
  [72, "#e5b93f"],
  [165, "#46a671"],
  [200, "#3ba3a8"],
  [262, "#4479d4"],
  [335, "#9063c4"],
  [360, "#d8544f"],
];
/** Saturation from which a colour is replaced. Paler colours remain. */
const GLARING_SATURATION = 0.8;

/** Replaces a saturated colour, `#rrggbb`, by the muted colour of its hue. */
export function mutedColor(color: string): string {
  const [r = 0, g = 0, b = 0] = /^#([0-9a-f]{2})([0-9a-f]{2})([0-9a-f]{2})$/i
    .exec(color)
    ?.slice(1)
    .map((two) => Number.parseInt(two, 16)) ?? [0, 0, 0];
  const [most, least] = [Math.max(r, g, b), Math.min(r, g, b)];
  const chroma = most - least;
  if (chroma === 0 || chroma / most < GLARING_SATURATION || most < 90) return color;
  const sixth = most === r ? ((g - b) / chroma + 6) % 6 : most === g ? (b - r) / chroma + 2 : (r - g) / chroma + 4;
  return PALETTE.find(([upTo]) => sixth * 60 <= upTo)?.[1] ?? color;
}
