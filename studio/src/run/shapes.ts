// Shapes to add to the sheet. Each is an SVG in mm, which the core reads like any drawing.
export const SHAPES = ["line", "arrow", "rectangle", "circle", "triangle", "star", "heart"] as const;
export type Shape = (typeof SHAPES)[number];

/** Initial size of a shape, mm. */
export const SIDE = 50;

const star = Array.from({ length: 10 }, (_, nth) => {
  const [radius, angle] = [nth % 2 === 0 ? 25 : 10, (nth * Math.PI) / 5];
  return `${(25 + radius * Math.sin(angle)).toFixed(2)} ${(25 - radius * Math.cos(angle)).toFixed(2)}`;
});

/** Path data of each shape in a square of this size. */
export const PATHS: Record<Shape, string> = {
  line: "M0 25H50",
  arrow: "M0 25H50M36 13L50 25L36 37",
  rectangle: "M0 8H50V42H0Z",
  circle: "M0 25A25 25 0 0 1 50 25A25 25 0 0 1 0 25Z",
  triangle: "M25 3L50 46H0Z",
  star: `M${star.join("L")}Z`,
  heart: "M25 46C8 33 0 24 0 15C0 7 6 2 13 2C18 2 23 5 25 10C27 5 32 2 37 2C44 2 50 7 50 15C50 24 42 33 25 46Z",
};

/** SVG of a shape, stretched in height: a circle becomes an ellipse. */
export const svgOf = (shape: Shape, stretch = 1): string =>
  `<svg xmlns="http://www.w3.org/2000/svg" width="${SIDE}mm" height="${SIDE * stretch}mm" viewBox="0 0 ${SIDE} ${SIDE}" preserveAspectRatio="none"><path d="${PATHS[shape]}" fill="none" stroke="#000"/></svg>`;
