// Surroundings of the arm: table, grid, light, and soft contact shadows.
import {
  AmbientLight,
  BufferGeometry,
  Color,
  DirectionalLight,
  Float32BufferAttribute,
  Group,
  HemisphereLight,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshBasicMaterial,
  PlaneGeometry,
  ShadowMaterial,
} from "three";
import { disposeOf } from "./mesh";

/** Radius at which the table fades out, mm. */
const RADIUS = 560;
/** Radius of the grid, and its pitch, mm. */
const [GRID, STEP] = [400, 50];
/** Positions of the axes' letters, mm from the shoulder. */
export const LETTERS = { x: [345, 0], y: [0, 265] } as const;

function faded(positions: number[], colors: number[], corners?: number[]): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new Float32BufferAttribute(positions, 3));
  geometry.setAttribute("color", new Float32BufferAttribute(colors, 4));
  if (corners) geometry.setIndex(corners);
  return geometry;
}

/** Rectangular shadow that fades out over `blur` mm, without a texture. */
export function softShadow(length: number, width: number, blur: number, opacity: number): Mesh {
  const [positions, colors, corners]: [number[], number[], number[]] = [[], [], []];
  const across = 24;
  const [half, wide] = [length / 2 - blur / 3, width / 2 - blur / 3];
  const rings = [
    [0, 1],
    [0.25, 0.8],
    [0.55, 0.38],
    [0.8, 0.1],
    [1, 0],
  ] as const;
  positions.push(0, 0, 0);
  colors.push(0, 0, 0, 1);
  rings.forEach(([share, dark], ring) => {
    for (let at = 0; at < across; at++) {
      const angle = ((at + 0.5) / across) * 2 * Math.PI;
      const [c, s] = [Math.cos(angle), Math.sin(angle)];
      positions.push(Math.sign(c) * half + c * blur * share * 1.3, Math.sign(s) * wide + s * blur * share * 1.3, 0);
      colors.push(0, 0, 0, dark);
      const [own, next] = [1 + ring * across + at, 1 + ring * across + ((at + 1) % across)];
      if (ring === 0) corners.push(0, own, next);
      else corners.push(own - across, own, next, own - across, next, next - across);
    }
  });
  const material = new MeshBasicMaterial({ vertexColors: true, transparent: true, opacity, depthWrite: false });
  return new Mesh(faded(positions, colors, corners), material);
}

export class Ground {
  readonly group = new Group();
  readonly sun = new DirectionalLight(0xffffff, 2);
  readonly lights = new Group();
  private parts = new Group();

  constructor() {
    const { sun } = this;
    sun.position.set(420, -380, 800);
    sun.castShadow = true;
    sun.shadow.mapSize.set(1024, 1024);
    sun.shadow.radius = 5;
    sun.shadow.bias = -0.0015;
    sun.shadow.normalBias = 1.5;
    const box = sun.shadow.camera;
    [box.left, box.right, box.top, box.bottom, box.near, box.far] = [-420, 420, 420, -420, 200, 1800];
    const rim = new DirectionalLight(0xdfe9ff, 0.7);
    rim.position.set(-300, 420, 260);
    this.lights.add(new HemisphereLight(0xffffff, 0xb4bcc6, 1.75), new AmbientLight(0xffffff, 0.3), sun, rim);
  }

  /** Builds the table in the page's colours. */
  setColors(lines: string, strong: string, top: string): void {
    disposeOf(this.parts);
    this.parts = new Group();
    this.group.add(this.parts);
    const [positions, colors]: [number[], number[]] = [[], []];
    const corner = (x: number, y: number, color: Color) => {
      positions.push(x, y, 0);
      const share = Math.hypot(x, y) / GRID;
      colors.push(color.r, color.g, color.b, Math.min(1, Math.max(0, 2.6 - 2.6 * share)));
    };
    const [plain, axis] = [new Color(lines), new Color(strong)];
    for (let at = -GRID; at <= GRID; at += STEP) {
      for (let from = -GRID; from < GRID; from += STEP / 2) {
        const to = from + STEP / 2;
        const isAxis = at === 0;
        corner(at, from, isAxis ? axis : plain);
        corner(at, to, isAxis ? axis : plain);
        corner(from, at, isAxis ? axis : plain);
        corner(to, at, isAxis ? axis : plain);
      }
    }
    const grid = new LineSegments(
      faded(positions, colors),
      new LineBasicMaterial({ vertexColors: true, transparent: true, depthWrite: false }),
    );
    grid.position.z = 0.2;
    this.parts.add(this.table(top), grid);
    const shadows = new Mesh(new PlaneGeometry(2 * RADIUS, 2 * RADIUS), new ShadowMaterial({ opacity: 0.15 }));
    shadows.receiveShadow = true;
    shadows.position.z = 0.1;
    const base = softShadow(158, 158, 40, 0.3);
    base.position.z = 0.3;
    this.parts.add(shadows, base);
  }

  private table(top: string): Mesh {
    const [positions, colors, corners]: [number[], number[], number[]] = [[0, 0, 0], [], []];
    const { r, g, b } = new Color(top);
    const [across, rings] = [48, [0.5, 0.68, 0.84, 1]];
    colors.push(r, g, b, 0.85);
    rings.forEach((share, ring) => {
      for (let at = 0; at < across; at++) {
        const angle = (at / across) * 2 * Math.PI;
        positions.push(Math.cos(angle) * share * RADIUS, Math.sin(angle) * share * RADIUS, 0);
        colors.push(r, g, b, [0.85, 0.6, 0.2, 0][ring] ?? 0);
        const [own, next] = [1 + ring * across + at, 1 + ring * across + ((at + 1) % across)];
        if (ring === 0) corners.push(0, own, next);
        else corners.push(own - across, own, next, own - across, next, next - across);
      }
    });
    const material = new MeshBasicMaterial({ vertexColors: true, transparent: true, depthWrite: false });
    const table = new Mesh(faded(positions, colors, corners), material);
    table.renderOrder = -1;
    return table;
  }

  end(): void {
    disposeOf(this.parts);
    this.sun.dispose();
  }
}
