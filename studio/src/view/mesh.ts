// Conversion of solids to three.js geometries, and their disposal.
import { BufferGeometry, Color, Float32BufferAttribute, type Material, type Mesh, type Object3D } from "three";
import type { Part } from "./body";
import { normalsOf } from "./solid";

/** Merges solids into one geometry with a colour for each. */
export function merged(parts: ReadonlyArray<Pick<Part, "color" | "solid">>): BufferGeometry {
  const [positions, normals, colors]: [number[], number[], number[]] = [[], [], []];
  for (const { solid, color } of parts) {
    const { r, g, b } = new Color(color);
    for (const value of solid) positions.push(value);
    for (const value of normalsOf(solid)) normals.push(value);
    for (let corner = 0; corner < solid.length; corner += 3) colors.push(r, g, b);
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new Float32BufferAttribute(positions, 3));
  geometry.setAttribute("normal", new Float32BufferAttribute(normals, 3));
  geometry.setAttribute("color", new Float32BufferAttribute(colors, 3));
  return geometry;
}

/** Geometry of one solid, for a material with a separate colour. */
export function solidGeometry(solid: number[]): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new Float32BufferAttribute(solid, 3));
  geometry.setAttribute("normal", new Float32BufferAttribute(normalsOf(solid), 3));
  return geometry;
}

/** Removes a part from the scene and frees its graphics memory. */
export function disposeOf(part: Object3D): void {
  part.removeFromParent();
  part.traverse((one: Object3D) => {
    const { geometry, material } = one as Partial<Mesh>;
    geometry?.dispose();
    (material as Material | undefined)?.dispose();
  });
}
