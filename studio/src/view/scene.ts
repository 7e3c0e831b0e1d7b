// The arm in 3D: the links that the arm names, at the joints that it reads. One unit is a millimetre.
import {
  AmbientLight,
  BufferAttribute,
  BufferGeometry,
  CylinderGeometry,
  DirectionalLight,
  Float32BufferAttribute,
  Group,
  HemisphereLight,
  Line,
  LineBasicMaterial,
  LineLoop,
  LineSegments,
  Mesh,
  MeshBasicMaterial,
  MeshStandardMaterial,
  PCFShadowMap,
  PerspectiveCamera,
  PlaneGeometry,
  Scene,
  ShadowMaterial,
  SphereGeometry,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { RoundedBoxGeometry } from "three/addons/geometries/RoundedBoxGeometry.js";
import type { State } from "../api";
import type { Model } from "../store";
import type { Layer, Shapes } from "./layers";
import { type Css, dragging, drop, shapesOf } from "./shapes";

export type View = "corner" | "front" | "side" | "top";
type Joint = "j1" | "j2" | "j3" | "j4" | "rail";
type LinkRow = Model["links"][number];

/** Where the camera stands from what it looks at, as a direction. */
const FROM: Record<View, [number, number, number]> = {
  // x leads away and to the right, y to the left.
  corner: [-0.72, -0.5, 0.46],
  front: [1, 0, 0.06],
  side: [0, -1, 0.06],
  top: [-0.001, 0, 1],
};
const DISTANCE = 1000;
const TRAIL = 400;
/** For so long a piece of the path is seen, ms. */
const FADES = 20_000;
/** A new reading is reached within this time, ms: about as long as two lie apart. */
const GLIDE = 60;
/** Where so many frames one after the other take longer than this, ms, no graphics chip draws them. */
const SLOW = 36;
const SLOW_FRAMES = 20;
/** So many pixels are drawn then for each of the page's. */
const COARSE = 0.5;

export interface Drawn {
  /** The tool's tip, css pixels from the upper left. */
  tip: [number, number];
  camera: number[];
  fps: number | null;
  /** Where the letters of the axes stand. */
  axes: Record<"x" | "y", [number, number]>;
}

/** What drivers that compute pictures without a graphics chip are called: Chromium does not tell it in another way. */
const PROCESSORS = /SwiftShader|llvmpipe|softpipe|Basic Render|Software/i;

function isDrawnByProcessor(gl: WebGLRenderingContext | WebGL2RenderingContext): boolean {
  const named = gl.getExtension("WEBGL_debug_renderer_info")?.UNMASKED_RENDERER_WEBGL ?? gl.RENDERER;
  return PROCESSORS.test(String(gl.getParameter(named)));
}

export class ArmScene {
  onDrawn: (drawn: Drawn) => void = () => {};
  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly camera = new PerspectiveCamera(32, 1, 20, 6000);
  private readonly controls: OrbitControls;
  private readonly root = new Group();
  private readonly grid = new Group();
  private readonly reach = new Group();
  private readonly joints: Array<{ group: Group; row: LinkRow; joint: Joint; sign: number }> = [];
  private readonly shown: Record<Joint, number> = { j1: 0, j2: 0, j3: 0, j4: 0, rail: 0 };
  private wanted: Record<Joint, number> | null = null;
  private from: Record<Joint, number> = { ...this.shown };
  private moveAt = 0;
  private tip = new Group();
  private readonly trail: Array<{ at: Vector3; t: number }> = [];
  private readonly trailLine: Line;
  private readonly still = matchMedia("(prefers-reduced-motion: reduce)");
  private flight: { from: Vector3; to: Vector3; since: number } | null = null;
  private follows = false;
  private frame = 0;
  private faded: ReturnType<typeof setTimeout> | undefined;
  private due: ReturnType<typeof setTimeout> | undefined;
  private lastDraw = 0;
  private fps: number | null = null;
  private floor = 0;
  private slow = 0;
  /** One picture for each reading, without shadows and with fewer pixels: what is beside it is shown first. */
  private spares = false;
  private readonly sun = new DirectionalLight(0xffffff, 2.1);
  private readonly sizes: ResizeObserver;
  private readonly layers = new Map<Layer, { group: Group; shapes: Shapes }>();
  private readonly endDragging: () => void;

  constructor(private readonly place: HTMLElement) {
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.renderer.domElement.setAttribute("aria-hidden", "true");
    place.prepend(this.renderer.domElement);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.enableDamping = !this.still.matches;
    this.controls.dampingFactor = 0.15;
    this.controls.minDistance = 200;
    this.controls.maxDistance = 3000;
    this.controls.target.set(80, 0, -25);
    this.controls.addEventListener("change", () => this.wake());
    this.controls.addEventListener("start", () => (this.flight = null));
    this.light();
    if (isDrawnByProcessor(this.renderer.getContext())) this.spare();
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(new Float32Array(TRAIL * 3), 3));
    geometry.setAttribute("color", new BufferAttribute(new Float32Array(TRAIL * 4), 4));
    this.trailLine = new Line(
      geometry,
      new LineBasicMaterial({ vertexColors: true, transparent: true, depthWrite: false }),
    );
    this.trailLine.frustumCulled = false;
    this.scene.add(this.root, this.grid, this.reach, this.trailLine);
    this.sizes = new ResizeObserver(() => this.resize());
    this.sizes.observe(place);
    this.resize();
    this.look("corner", true);
    const turned = (is: boolean) => (this.controls.enabled = is);
    this.endDragging = dragging(
      place,
      this.camera,
      () => this.layers.get("objects")?.group,
      turned,
      () => this.wake(),
    );
  }

  private light(): void {
    this.scene.add(new HemisphereLight(0xffffff, 0x9aa3ad, 1.5), new AmbientLight(0xffffff, 0.35));
    const { sun } = this;
    sun.position.set(-250, -420, 800);
    sun.castShadow = true;
    sun.shadow.mapSize.set(1024, 1024);
    sun.shadow.radius = 5;
    const box = sun.shadow.camera;
    [box.left, box.right, box.top, box.bottom, box.near, box.far] = [-420, 420, 420, -420, 200, 1800];
    this.scene.add(sun);
  }

  /** Makes the arm of its table. */
  setModel(model: Model): void {
    this.root.clear();
    this.joints.length = 0;
    this.trail.length = 0;
    const groups = new Map<string, Group>();
    for (const row of model.links) {
      const group = new Group();
      group.position.fromArray(row.at);
      const mesh = meshOf(row);
      group.add(mesh);
      (groups.get(row.parent ?? "") ?? this.root).add(group);
      groups.set(row.name, group);
      if (row.joint !== null) {
        const name = row.joint.replace("-", "");
        const joint = (name === "l" ? "rail" : name) as Joint;
        this.joints.push({ group, row, joint, sign: row.joint.startsWith("-") ? -1 : 1 });
      }
      this.tip = group;
    }
    const dot = new Mesh(
      new SphereGeometry(4, 20, 14),
      new MeshBasicMaterial({ color: 0x2f8fff, depthTest: false, transparent: true }),
    );
    dot.renderOrder = 1;
    this.tip.add(dot);
    const base = model.links[0];
    this.floor = base === undefined ? 0 : (base.at[2] ?? 0) - (base.size[2] ?? 0);
    this.pose();
    this.wake();
  }

  setState(state: State): void {
    const { j1, j2, j3, j4, rail } = state;
    const next = { j1, j2, j3, j4, rail: rail ?? 0 };
    const before = this.wanted;
    // An arm that stands costs no frame.
    if (before !== null && (Object.keys(next) as Joint[]).every((joint) => next[joint] === before[joint])) return;
    const first = before === null;
    this.from = { ...this.shown };
    this.wanted = next;
    this.moveAt = performance.now();
    if (first) {
      Object.assign(this.shown, next);
      this.from = { ...next };
      this.pose();
    }
    this.wake();
  }

  setReach(outlines: number[][][], z: number, color: string): void {
    this.reach.clear();
    for (const outline of outlines) {
      const points = outline.flatMap(([x, y]) => [x ?? 0, y ?? 0, 0]);
      const geometry = new BufferGeometry();
      geometry.setAttribute("position", new Float32BufferAttribute(points, 3));
      const line = new LineLoop(geometry, new LineBasicMaterial({ color, transparent: true, opacity: 0.75 }));
      line.position.z = z;
      const shadow = new LineLoop(geometry, new LineBasicMaterial({ color, transparent: true, opacity: 0.22 }));
      shadow.position.z = this.floor + 0.5;
      this.reach.add(line, shadow);
    }
    this.wake();
  }

  /** Shows these layers and no others. */
  setLayers(layers: ReadonlyMap<Layer, Shapes>, css: Css, anew = false): void {
    for (const [name, { group, shapes }] of this.layers) {
      if (!anew && layers.get(name) === shapes) continue;
      drop(group);
      this.layers.delete(name);
    }
    for (const [name, shapes] of layers) {
      if (this.layers.has(name)) continue;
      const group = shapesOf(shapes, css);
      this.layers.set(name, { group, shapes });
      this.scene.add(group);
    }
    this.wake();
  }

  /** The table, in the colours of the page. */
  setColors(lines: string, strong: string): void {
    this.grid.clear();
    const [half, step] = [400, 50];
    const positions: Record<string, number[]> = { [lines]: [], [strong]: [] };
    for (let at = -half; at <= half; at += step) {
      const to = positions[at === 0 ? strong : lines];
      to?.push(at, -half, 0, at, half, 0, -half, at, 0, half, at, 0);
    }
    for (const [color, points] of Object.entries(positions)) {
      const geometry = new BufferGeometry();
      geometry.setAttribute("position", new Float32BufferAttribute(points, 3));
      this.grid.add(new LineSegments(geometry, new LineBasicMaterial({ color })));
    }
    const ground = new Mesh(new PlaneGeometry(2 * half, 2 * half), new ShadowMaterial({ opacity: 0.16 }));
    ground.receiveShadow = true;
    ground.position.z = -0.5;
    this.grid.add(ground);
    this.grid.position.z = this.floor;
    this.wake();
  }

  look(view: View, atOnce = false): void {
    const narrow = Math.max(1, 1.15 / this.camera.aspect);
    const to = new Vector3(...FROM[view])
      .normalize()
      .multiplyScalar(DISTANCE * narrow)
      .add(this.controls.target);
    if (atOnce || this.still.matches) {
      this.camera.position.copy(to);
      this.flight = null;
    } else {
      this.flight = { from: this.camera.position.clone(), to, since: performance.now() };
    }
    this.wake();
  }

  setFollow(follows: boolean): void {
    this.follows = follows;
    if (!follows) this.moveTarget(new Vector3(80, 0, -25), 1);
    this.wake();
  }

  end(): void {
    cancelAnimationFrame(this.frame);
    clearTimeout(this.due);
    clearTimeout(this.faded);
    this.sizes.disconnect();
    this.endDragging();
    for (const { group } of this.layers.values()) drop(group);
    this.controls.dispose();
    this.renderer.dispose();
    this.renderer.domElement.remove();
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.place;
    if (width === 0 || height === 0) return;
    this.renderer.setSize(width, height);
    const before = Math.max(1, 1.15 / this.camera.aspect);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    const by = Math.max(1, 1.15 / this.camera.aspect) / before;
    this.camera.position.sub(this.controls.target).multiplyScalar(by).add(this.controls.target);
    this.wake();
  }

  private pose(): void {
    for (const { group, row, joint, sign } of this.joints) {
      const axis = new Vector3().fromArray(row.axis);
      const value = sign * this.shown[joint];
      if (joint === "rail") group.position.fromArray(row.at).addScaledVector(axis, value);
      else group.quaternion.setFromAxisAngle(axis, (value * Math.PI) / 180);
    }
  }

  private moveTarget(to: Vector3, share: number): void {
    const step = to.sub(this.controls.target).multiplyScalar(share);
    this.controls.target.add(step);
    this.camera.position.add(step);
  }

  private wake(): void {
    if (this.frame !== 0) return;
    // A frame waits for every canvas in it: the numbers of this reading go ahead of its picture.
    this.frame = requestAnimationFrame(() => {
      if (this.spares) this.due = setTimeout(() => this.draw());
      else this.draw();
    });
  }

  private draw(): void {
    this.frame = 0;
    clearTimeout(this.faded);
    const now = performance.now();
    let goesOn = false;
    if (this.wanted !== null) {
      const share = this.spares ? 1 : Math.min(1, (now - this.moveAt) / GLIDE);
      for (const joint of Object.keys(this.shown) as Joint[]) {
        this.shown[joint] = this.from[joint] + (this.wanted[joint] - this.from[joint]) * share;
      }
      this.pose();
      goesOn ||= share < 1;
    }
    if (this.flight !== null) {
      const share = Math.min(1, (now - this.flight.since) / 350);
      const eased = 1 - (1 - share) ** 3;
      const length =
        this.flight.from.distanceTo(this.controls.target) * (1 - eased) +
        this.flight.to.distanceTo(this.controls.target) * eased;
      this.camera.position
        .lerpVectors(this.flight.from, this.flight.to, eased)
        .sub(this.controls.target)
        .setLength(length)
        .add(this.controls.target);
      if (share >= 1) this.flight = null;
      goesOn ||= share < 1;
    }
    this.root.updateMatrixWorld(true);
    const tip = new Vector3().setFromMatrixPosition(this.tip.matrixWorld);
    if (this.follows) {
      const away = tip.clone().sub(this.controls.target);
      if (away.length() > 0.5) {
        this.moveTarget(tip.clone(), this.still.matches ? 1 : 0.12);
        goesOn = true;
      }
    }
    const fades = this.drawTrail(tip, now);
    this.controls.update();
    this.camera.updateMatrixWorld();
    this.renderer.render(this.scene, this.camera);
    this.count(now);
    this.tell(tip);
    if (goesOn) this.wake();
    else if (fades) this.faded = setTimeout(() => this.wake(), 150);
  }

  /** The way of the tip, older pieces fainter; whether any is still seen. */
  private drawTrail(tip: Vector3, now: number): boolean {
    const last = this.trail[this.trail.length - 1];
    if (this.wanted !== null && this.joints.length > 0 && (last === undefined || last.at.distanceTo(tip) > 0.8)) {
      this.trail.push({ at: tip.clone(), t: now });
      if (this.trail.length > TRAIL) this.trail.shift();
    }
    while (this.trail.length > 1 && now - (this.trail[0]?.t ?? 0) > FADES) this.trail.shift();
    const { position, color } = this.trailLine.geometry.attributes as Record<string, BufferAttribute>;
    this.trail.forEach(({ at, t }, place) => {
      position?.setXYZ(place, at.x, at.y, at.z);
      color?.setXYZW(place, 0.18, 0.56, 1, Math.max(0, 1 - (now - t) / FADES));
    });
    if (position && color) position.needsUpdate = color.needsUpdate = true;
    this.trailLine.geometry.setDrawRange(0, this.trail.length);
    return this.trail.length > 1;
  }

  /** Frames a second, as long as one follows the other. */
  private count(now: number): void {
    const gap = now - this.lastDraw;
    this.lastDraw = now;
    if (gap > 120) return;
    this.fps = this.fps === null ? 1000 / gap : this.fps * 0.9 + 100 / gap;
    this.slow = gap > SLOW ? this.slow + 1 : 0;
    if (this.slow > SLOW_FRAMES) this.spare();
  }

  private spare(): void {
    if (this.spares) return;
    this.spares = true;
    this.sun.castShadow = false;
    this.renderer.setPixelRatio(COARSE);
  }

  private tell(tip: Vector3): void {
    const { clientWidth: width, clientHeight: height } = this.place;
    const pixel = (at: Vector3): [number, number] => {
      const { x, y } = at.clone().project(this.camera);
      return [((x + 1) / 2) * width, ((1 - y) / 2) * height];
    };
    const camera = this.camera.projectionMatrix.clone().multiply(this.camera.matrixWorldInverse);
    const axes = { x: pixel(new Vector3(425, 0, this.floor)), y: pixel(new Vector3(0, 425, this.floor)) };
    this.onDrawn({ tip: pixel(tip), camera: camera.toArray(), fps: this.fps, axes });
  }
}

/** What a link looks like: it stands on the origin of its frame along z, turned. */
function meshOf(row: LinkRow): Mesh {
  const [x = 0, y = 0, z = 0] = row.size;
  const material = new MeshStandardMaterial({ color: row.color, roughness: 0.62, metalness: 0.05 });
  let geometry: BufferGeometry;
  if (row.shape === "sphere") {
    geometry = new SphereGeometry(x / 2, 32, 20);
  } else if (row.shape === "cylinder") {
    geometry = new CylinderGeometry(x / 2, x / 2, z, 48).rotateX(Math.PI / 2).translate(0, 0, z / 2);
  } else {
    geometry = new RoundedBoxGeometry(x, y, z, 3, Math.min(5, x / 4, y / 4, z / 4)).translate(0, 0, z / 2);
  }
  const mesh = new Mesh(geometry, material);
  const turn = row.turn.map((degrees) => (degrees * Math.PI) / 180);
  mesh.rotation.set(turn[0] ?? 0, turn[1] ?? 0, turn[2] ?? 0, "ZYX");
  mesh.castShadow = mesh.receiveShadow = true;
  return mesh;
}
