// 3D picture of one arm, rendered only on changes. One unit is one millimetre.
import {
  BufferAttribute,
  BufferGeometry,
  Float32BufferAttribute,
  Group,
  Line,
  LineBasicMaterial,
  LineLoop,
  type Mesh,
  PCFShadowMap,
  Plane,
  Raycaster,
  Scene,
  Vector2,
  Vector3,
  WebGLRenderer,
} from "three";
import type { State } from "../api";
import type { Model } from "../store";
import { measuresOf, type ToolName } from "./body";
import { opacityOf } from "./camera";
import { Contacts } from "./contacts";
import { Figure, type Joints } from "./figure";
import { boundsOf } from "./flat";
import { Ground, LETTERS } from "./ground";
import type { Layer, Shapes, Target } from "./layers";
import { disposeOf } from "./mesh";
import { CameraRig } from "./rig";
import { type Css, dragging, shapesOf } from "./shapes";
import type { Point } from "./solid";
import { type Stand, standOn } from "./stand";

const MAX_TRAIL = 400;
/** Time for which a piece of the path is visible, ms. */
const TRAIL_DURATION = 20_000;
/** Duration of the transition to a new state, ms: about the interval between two states. */
const GLIDE_DURATION = 60;
/**
 * Frame time, ms, that indicates rendering without a graphics chip after `SLOW_FRAMES` consecutive
 * frames.
 */
const SLOW_FRAME_TIME = 36;
const SLOW_FRAMES = 20;
/** Pixel ratio for rendering without a graphics chip. */
const SLOW_PIXEL_RATIO = 0.5;
/** Shortest interval between reports of the tip and camera while the picture moves, ms. */
const REPORT_INTERVAL = 250;
/** Largest movement of a press on the table, px. */
const PRESS_TOLERANCE = 6;
/** Largest x and y of work that the camera frames, mm. Farther work is clamped to it. */
const WORK_LIMIT = 330;
export interface DrawnFrame {
  /** Tip of the tool, CSS pixels from the upper left corner. */
  tip: [number, number];
  camera: number[];
}

/** Names of drivers that render without a graphics chip. Chromium reports it in no other way. */
const SOFTWARE_RENDERERS = /SwiftShader|llvmpipe|softpipe|Basic Render|Software/i;

function isSoftwareRenderer(gl: WebGLRenderingContext | WebGL2RenderingContext): boolean {
  const named = gl.getExtension("WEBGL_debug_renderer_info")?.UNMASKED_RENDERER_WEBGL ?? gl.RENDERER;
  return SOFTWARE_RENDERERS.test(String(gl.getParameter(named)));
}

export class ArmScene {
  /**
   * Called with the tip and camera when the picture is at rest, and at intervals while it moves.
   */
  onDrawn: (drawn: DrawnFrame) => void = () => {};
  /** Called with the positions of the axes' letters after every camera motion. */
  onTurned: (letters: Record<"x" | "y", [number, number]>) => void = () => {};
  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  readonly rig: CameraRig;
  private readonly figure = new Figure();
  private readonly ground = new Ground();
  private readonly reach = new Group();
  private readonly contacts = new Contacts();
  private ghost: Group | null = null;
  private model: Model | null = null;
  private tool: ToolName | null = null;
  private stand: Stand = standOn(null, 0);
  private builtKey = "";
  private readonly shown: Joints = { j1: 0, j2: 0, j3: 0, j4: 0, rail: 0 };
  private targetJoints: Joints | null = null;
  private from: Joints = { ...this.shown };
  private moveAt = 0;
  private state: State | null = null;
  private target: Target | null = null;
  private readonly trail: Array<{ at: Vector3; t: number }> = [];
  private readonly trailLine: Line;
  private readonly reducedMotion = matchMedia("(prefers-reduced-motion: reduce)");
  private frame = 0;
  private fadeTimer: ReturnType<typeof setTimeout> | undefined;
  private drawTimer: ReturnType<typeof setTimeout> | undefined;
  private lastDraw = 0;
  private reportedAt = 0;
  private framedContent = "";
  private slowFrames = 0;
  /**
   * Economy mode without a graphics chip: one frame for each state, no shadows, fewer pixels, and
   * the rest of the page is rendered first.
   */
  private isEconomical = false;
  private readonly sizes: ResizeObserver;
  private readonly layers = new Map<Layer, { group: Group; shapes: Shapes }>();
  private readonly listenersEnd = new AbortController();
  private readonly endDragging: () => void;

  constructor(
    private readonly place: HTMLElement,
    press: (x: number, y: number) => void,
  ) {
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.renderer.domElement.setAttribute("aria-hidden", "true");
    place.prepend(this.renderer.domElement);
    this.rig = new CameraRig(this.renderer.domElement, this.reducedMotion, () => this.wake());
    this.rig.visiblePoints = () => this.visiblePoints();
    if (isSoftwareRenderer(this.renderer.getContext())) this.economize();
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(new Float32Array(MAX_TRAIL * 3), 3));
    geometry.setAttribute("color", new BufferAttribute(new Float32Array(MAX_TRAIL * 4), 4));
    this.trailLine = new Line(
      geometry,
      new LineBasicMaterial({ vertexColors: true, transparent: true, depthWrite: false }),
    );
    this.trailLine.frustumCulled = false;
    const { ground } = this;
    this.scene.add(this.figure.root, ground.group, ground.lights, this.reach, this.contacts.group, this.trailLine);
    this.sizes = new ResizeObserver(() => this.resize());
    this.sizes.observe(place);
    this.resize();
    this.rig.look("corner", true);
    const turned = (is: boolean) => (this.rig.controls.enabled = is);
    const objects = () => this.layers.get("objects")?.group;
    this.endDragging = dragging(place, this.rig.camera, objects, turned, () => this.wake());
    this.listen(press);
  }

  /**
   * Listens for presses on the table in the view from above. A drag that turns the picture is not a
   * press.
   */
  private listen(press: (x: number, y: number) => void): void {
    let down: { x: number; y: number } | null = null;
    const { signal } = this.listenersEnd;
    const canvas = this.renderer.domElement;
    // A second finger means a pinch.
    const begin = ({ isPrimary, clientX, clientY }: PointerEvent) =>
      (down = isPrimary ? { x: clientX, y: clientY } : null);
    canvas.addEventListener("pointerdown", begin, { signal });
    const up = (event: PointerEvent) => {
      const from = down;
      down = null;
      if (from === null || Math.hypot(event.clientX - from.x, event.clientY - from.y) > PRESS_TOLERANCE) return;
      const at = this.tableAt(event);
      if (this.rig.isAbove() && at !== null) press(at.x, at.y);
    };
    canvas.addEventListener("pointerup", up, { signal });
  }

  private tableAt({ clientX, clientY }: PointerEvent): Vector3 | null {
    const { left, top, width, height } = this.place.getBoundingClientRect();
    const ray = new Raycaster();
    const at = new Vector2(((clientX - left) / width) * 2 - 1, 1 - ((clientY - top) / height) * 2);
    ray.setFromCamera(at, this.rig.camera);
    return ray.ray.intersectPlane(new Plane(new Vector3(0, 0, 1), -this.stand.surface), new Vector3());
  }

  /** Sets the arm's model, its tool and the height of its table. */
  setModel(model: Model, tool: ToolName | null, table: number | null): void {
    const { base, turret } = measuresOf(model);
    const stand = standOn(table, base + turret, model.tool.bias[2] ?? 0);
    const key = JSON.stringify([model.links, tool, stand]);
    if (key === this.builtKey) return;
    this.builtKey = key;
    [this.model, this.tool, this.stand] = [model, tool, stand];
    this.figure.build(model, tool, stand.lift);
    this.ground.group.position.z = stand.floor;
    this.trail.length = 0;
    this.figure.pose(this.shown);
    this.updateGhost();
    this.reframe();
  }

  setState(state: State): void {
    const { j1, j2, j3, j4, rail } = state;
    const next = { j1, j2, j3, j4, rail: rail ?? 0 };
    const before = this.targetJoints;
    const tools = this.state?.tool;
    this.state = state;
    const isSame = tools?.laser === state.tool.laser && tools?.gripper === state.tool.gripper;
    if (!isSame) this.updateGripper();
    // An unchanged state needs no frame.
    if (
      before !== null &&
      isSame &&
      (Object.keys(next) as Array<keyof Joints>).every((name) => next[name] === before[name])
    )
      return;
    this.from = { ...this.shown };
    this.targetJoints = next;
    this.moveAt = performance.now();
    if (before === null) {
      Object.assign(this.shown, next);
      this.from = { ...next };
      this.figure.pose(this.shown);
    }
    this.wake();
  }

  private boxesOf(layer: Layer): Shapes["boxes"] {
    return this.layers.get(layer)?.shapes.boxes ?? [];
  }

  private updateGripper(): void {
    const things = this.boxesOf("objects");
    const width = things.find(({ held }) => held)?.size[1] ?? null;
    this.figure.setGripper(this.state?.tool.gripper ?? null, width);
  }

  setReach(outlines: number[][][], z: number, color: string): void {
    for (const child of [...this.reach.children]) disposeOf(child);
    for (const outline of outlines) {
      const points = outline.flatMap(([x, y]) => [x ?? 0, y ?? 0, 0]);
      const geometry = new BufferGeometry();
      geometry.setAttribute("position", new Float32BufferAttribute(points, 3));
      const line = new LineLoop(geometry, new LineBasicMaterial({ color, transparent: true, opacity: 0.6 }));
      line.position.z = z;
      const shadow = new LineLoop(geometry, new LineBasicMaterial({ color, transparent: true, opacity: 0.2 }));
      shadow.position.z = this.stand.surface + 0.6;
      this.reach.add(line, shadow);
    }
    this.wake();
  }

  /** Sets the target pose; null hides the translucent tool. */
  setTarget(target: Target | null): void {
    this.target = target;
    this.updateGhost();
    this.wake();
  }

  private updateGhost(): void {
    if (this.ghost !== null) disposeOf(this.ghost);
    this.ghost = null;
    const { target, model } = this;
    if (target === null || model === null) return;
    this.ghost = this.figure.ghost(model, this.tool, this.stand.lift);
    this.ghost.position.set(target.x, target.y, target.z);
    this.ghost.rotation.z = (target.r * Math.PI) / 180;
    this.scene.add(this.ghost);
  }

  /** Shows these layers and removes all others. */
  setLayers(layers: ReadonlyMap<Layer, Shapes>, css: Css, anew = false): void {
    for (const [name, { group, shapes }] of this.layers) {
      if (!anew && layers.get(name) === shapes) continue;
      disposeOf(group);
      this.layers.delete(name);
    }
    for (const [name, shapes] of layers) {
      if (this.layers.has(name)) continue;
      const group = shapesOf(shapes, css);
      this.layers.set(name, { group, shapes });
      this.scene.add(group);
    }
    const things = (this.layers.get("objects")?.group.children ?? []) as Mesh[];
    this.contacts.update(things, this.boxesOf("belt"), this.state);
    this.updateGripper();
    this.reframe();
  }

  setColors(lines: string, strong: string, top: string): void {
    this.ground.setColors(lines, strong, top);
    this.wake();
  }

  /** Points that must be visible: the arm, and the work in front of it. */
  private visiblePoints(): { points: Point[]; side: number } {
    const { floor, lift } = this.stand;
    const points: Point[] = [
      [-80, -79, floor],
      [-80, 79, floor],
      [80, -79, floor],
      [80, 79, floor],
      [-40, 0, lift + 150],
      [110, 0, lift + 150],
      [270, -30, lift + 40],
      [270, 30, lift + 40],
    ];
    const within = (value: number) => Math.min(WORK_LIMIT, Math.max(-WORK_LIMIT, value));
    const work: Point[] = [];
    for (const name of ["paper", "objects", "belt"] as const) {
      for (const { at, size, turn = 0 } of this.boxesOf(name)) {
        const [x = 0, y = 0, z = 0] = at;
        const [length = 0, width = 0, height = 0] = size;
        const [c, s] = [Math.cos((turn * Math.PI) / 180) / 2, Math.sin((turn * Math.PI) / 180) / 2];
        for (const [a, b] of [
          [1, 1],
          [1, -1],
          [-1, 1],
          [-1, -1],
        ] as const) {
          const px = x + a * length * c - b * width * s;
          work.push([Math.max(-100, within(px)), within(y + a * length * s + b * width * c), z + height]);
        }
      }
    }
    // A planned program that has not run yet may lie outside every sheet.
    const planned = (this.layers.get("planned")?.shapes.lines ?? []).flatMap(({ points }) => points);
    if (planned.length > 0) {
      const { x, y, width, height } = boundsOf(planned);
      const [left, right, low, high] = [within(x), within(x + width), within(y), within(y + height)];
      work.push([left, low, floor], [left, high, floor], [right, low, floor], [right, high, floor]);
    }
    if (work.length === 0) work.push([300, -150, floor], [300, 150, floor]);
    const side = work.reduce((sum, [, y]) => sum + y, 0) / work.length;
    return { points: [...points, ...work], side };
  }

  /**
   * Frames the picture after the objects on the table have changed, unless the user has turned it.
   */
  private reframe(): void {
    const fixed = (["paper", "belt"] as const).map((name) => this.boxesOf(name).map(({ at, size }) => [at, size]));
    const seen = JSON.stringify([this.stand, fixed, this.boxesOf("objects").map(({ name }) => name)]);
    if (seen !== this.framedContent) {
      const isFirst = this.reportedAt === 0;
      this.framedContent = seen;
      this.rig.reframe(isFirst);
    }
    this.wake();
  }

  end(): void {
    cancelAnimationFrame(this.frame);
    clearTimeout(this.drawTimer);
    clearTimeout(this.fadeTimer);
    this.listenersEnd.abort();
    this.sizes.disconnect();
    this.endDragging();
    for (const { group } of this.layers.values()) disposeOf(group);
    for (const group of [this.reach, this.contacts.group, this.trailLine, this.ghost])
      if (group !== null) disposeOf(group);
    this.figure.clear();
    this.ground.end();
    this.rig.controls.dispose();
    this.renderer.dispose();
    // Browsers permit only a few contexts and collect unreleased ones late.
    this.renderer.forceContextLoss();
    this.renderer.domElement.remove();
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.place;
    if (width === 0 || height === 0) return;
    this.renderer.setSize(width, height);
    this.rig.setSize(width, height);
    this.rig.reframe(true);
    this.wake();
  }

  private wake(): void {
    if (this.frame !== 0) return;
    // The browser presents a frame only when every canvas in it is rendered, so a slow canvas is
    // rendered after the page's numbers.
    this.frame = requestAnimationFrame(() => {
      if (this.isEconomical) this.drawTimer = setTimeout(() => this.draw());
      else this.draw();
    });
  }

  private draw(): void {
    this.frame = 0;
    clearTimeout(this.fadeTimer);
    const now = performance.now();
    let goesOn = this.figure.moveJaws(this.reducedMotion.matches || this.isEconomical ? 1 : undefined);
    if (this.targetJoints !== null) {
      const share = this.isEconomical ? 1 : Math.min(1, (now - this.moveAt) / GLIDE_DURATION);
      for (const joint of Object.keys(this.shown) as Array<keyof Joints>) {
        this.shown[joint] = this.from[joint] + (this.targetJoints[joint] - this.from[joint]) * share;
      }
      this.figure.pose(this.shown);
      goesOn ||= share < 1;
    }
    this.figure.root.updateMatrixWorld(true);
    const tip = new Vector3().setFromMatrixPosition(this.figure.tip.matrixWorld);
    goesOn = this.rig.step(tip, now) || goesOn;
    const goal = this.ghost?.position;
    // Near the tip the translucent tool would only overlap the tool.
    if (this.ghost !== null && goal) this.ghost.visible = goal.distanceTo(tip) > 2;
    const burns = this.tool === "laser" && this.state?.tool.laser === true;
    this.figure.showBeam(burns ? Math.max(0, tip.z - this.stand.surface) : null);
    this.contacts.carry(this.figure.tip, this.stand.surface);
    const fades = this.drawTrail(tip, now);
    const { camera, controls } = this.rig;
    controls.update();
    this.figure.setOpacity(opacityOf(this.rig.elevation()));
    camera.updateMatrixWorld();
    this.renderer.render(this.scene, camera);
    this.measure(now);
    this.report(tip, now, goesOn);
    if (goesOn) this.wake();
    else if (fades) this.fadeTimer = setTimeout(() => this.wake(), 150);
  }

  /** Draws the path of the tip, older pieces fainter. Returns true if any of it is visible. */
  private drawTrail(tip: Vector3, now: number): boolean {
    const last = this.trail[this.trail.length - 1];
    if (this.targetJoints !== null && this.model !== null && (last === undefined || last.at.distanceTo(tip) > 0.8)) {
      this.trail.push({ at: tip.clone(), t: now });
      if (this.trail.length > MAX_TRAIL) this.trail.shift();
    }
    while (this.trail.length > 1 && now - (this.trail[0]?.t ?? 0) > TRAIL_DURATION) this.trail.shift();
    const { position, color } = this.trailLine.geometry.attributes as Record<string, BufferAttribute>;
    this.trail.forEach(({ at, t }, place) => {
      position?.setXYZ(place, at.x, at.y, at.z);
      color?.setXYZW(place, 0.18, 0.56, 1, Math.max(0, 1 - (now - t) / TRAIL_DURATION));
    });
    if (position && color) position.needsUpdate = color.needsUpdate = true;
    this.trailLine.geometry.setDrawRange(0, this.trail.length);
    return this.trail.length > 1;
  }

  /** Consecutive slow frames indicate that there is no graphics chip. */
  private measure(now: number): void {
    const gap = now - this.lastDraw;
    this.lastDraw = now;
    if (gap > 120) return;
    this.slowFrames = gap > SLOW_FRAME_TIME ? this.slowFrames + 1 : 0;
    if (this.slowFrames > SLOW_FRAMES) this.economize();
  }

  private economize(): void {
    if (this.isEconomical) return;
    this.isEconomical = true;
    this.ground.sun.castShadow = false;
    this.renderer.setPixelRatio(SLOW_PIXEL_RATIO);
  }

  private report(tip: Vector3, now: number, goesOn: boolean): void {
    const { clientWidth: width, clientHeight: height } = this.place;
    const pixel = (at: Vector3): [number, number] => {
      const { x, y } = at.clone().project(this.rig.camera);
      return [((x + 1) / 2) * width, ((1 - y) / 2) * height];
    };
    const letter = ([x, y]: readonly [number, number]) => pixel(new Vector3(x, y, this.stand.floor));
    this.onTurned({ x: letter(LETTERS.x), y: letter(LETTERS.y) });
    if (goesOn && now - this.reportedAt < REPORT_INTERVAL) return;
    this.reportedAt = now;
    const { projectionMatrix, matrixWorldInverse } = this.rig.camera;
    const camera = projectionMatrix.clone().multiply(matrixWorldInverse);
    this.onDrawn({ tip: pixel(tip), camera: camera.toArray() });
  }
}
