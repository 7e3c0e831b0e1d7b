// Many arms in one canvas, by instancing: each part is one mesh for all arms. Every arm is drawn at
// the position of its tile in the page.
import {
  AmbientLight,
  DirectionalLight,
  HemisphereLight,
  InstancedMesh,
  Matrix4,
  MeshLambertMaterial,
  OrthographicCamera,
  Quaternion,
  Scene,
  Vector3,
  WebGLRenderer,
} from "three";
import type { Model } from "../store";
import { bodyOf, type Link, measuresOf, RODS, type Part as Solid, toolOf } from "./body";
import { directionOf } from "./camera";
import { disposeOf, merged } from "./mesh";
import { coarse } from "./solid";
import { standOn } from "./stand";

export type Joints = readonly [j1: number, j2: number, j3: number, j4: number, rail: number];
/** Rectangle in the page, CSS pixels from the upper left corner of the canvas. */
export interface Place {
  x: number;
  y: number;
  width: number;
  height: number;
}

const JOINT_NAMES = ["j1", "j2", "j3", "j4", "l"];
const RADIANS = Math.PI / 180;
/** Extent of an arm's surroundings along the shorter side of its tile, mm. */
const VIEW_EXTENT = 440;
/** Duration of the transition to a new state, ms. */
const GLIDE_DURATION = 320;

interface Part {
  /** Null for a link that only carries others. */
  mesh: InstancedMesh | null;
  parent: number;
  axis: Vector3;
  at: Vector3;
  joint: number;
  sign: number;
}

export class FleetScene {
  /** Called with the script time of a frame, ms. */
  onDrawn: (ms: number) => void = () => {};
  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly camera = new OrthographicCamera();
  private readonly parts: Part[] = [];
  private readonly shown: number[][] = [];
  private from: number[][] = [];
  private targets: number[][] = [];
  private readonly origins: Vector3[] = [];
  private scale = 1;
  private movedAt = 0;
  private frame = 0;
  private readonly frames: Matrix4[];
  private readonly turn = new Quaternion();
  private readonly step = new Matrix4();
  private readonly placed = new Matrix4();

  constructor(
    place: HTMLElement,
    model: Model,
    private readonly most: number,
  ) {
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.domElement.setAttribute("aria-hidden", "true");
    place.prepend(this.renderer.domElement);
    this.camera.up.set(0, 0, 1);
    this.camera.position.set(...directionOf("corner")).setLength(4000);
    this.camera.lookAt(0, 0, 0);
    this.camera.updateMatrixWorld();
    this.scene.add(new HemisphereLight(0xffffff, 0x9aa3ad, 1.6), new AmbientLight(0xffffff, 0.5));
    const sun = new DirectionalLight(0xffffff, 1.8);
    sun.position.set(420, -380, 800);
    this.scene.add(sun);
    const links = [...model.links, ...RODS];
    const order = links.map(({ name }) => name);
    // The mounted tools are unknown here, so all arms are drawn with a pointer.
    const measures = measuresOf(model);
    const { lift } = standOn(null, measures.base + measures.turret, model.tool.bias[2] ?? 0);
    const hang = lift - measures.tool[2];
    const solids = coarse(() => [...bodyOf(measures, hang, false), ...toolOf(null, hang)]);
    for (const link of links) {
      const own = solids.filter((solid) => solid.link === link.name);
      this.parts.push(this.part(link, order, own, link.name === "tool" ? lift : 0));
    }
    this.frames = this.parts.map(() => new Matrix4());
  }

  private part(link: Link, order: string[], solids: readonly Solid[], lower: number): Part {
    let mesh: InstancedMesh | null = null;
    if (solids.length > 0) {
      mesh = new InstancedMesh(merged(solids), new MeshLambertMaterial({ vertexColors: true }), this.most);
      mesh.frustumCulled = false;
      mesh.count = 0;
      this.scene.add(mesh);
    }
    const at = new Vector3().fromArray(link.at);
    at.z -= lower;
    return {
      mesh,
      parent: link.parent === null ? -1 : order.indexOf(link.parent),
      axis: new Vector3().fromArray(link.axis),
      at,
      joint: link.joint === null ? -1 : JOINT_NAMES.indexOf(link.joint.replace("-", "")),
      sign: link.joint?.startsWith("-") ? -1 : 1,
    };
  }

  /** Sets the rectangles of the arms in the page. */
  setPlaces(places: readonly Place[], width: number, height: number): void {
    this.renderer.setSize(width, height);
    this.scale = VIEW_EXTENT / Math.min(places[0]?.width ?? 1, places[0]?.height ?? 1);
    const [half, tall] = [(width * this.scale) / 2, (height * this.scale) / 2];
    Object.assign(this.camera, { left: -half, right: half, top: tall, bottom: -tall, near: 1, far: 9000 });
    this.camera.updateProjectionMatrix();
    const right = new Vector3().setFromMatrixColumn(this.camera.matrixWorld, 0);
    const up = new Vector3().setFromMatrixColumn(this.camera.matrixWorld, 1);
    // The centre of an arm's space is in front of its shoulder and below it.
    const middle = new Vector3(90, 0, 20);
    this.origins.length = 0;
    for (const { x, y, width: wide, height: high } of places) {
      const across = (x + wide / 2 - width / 2) * this.scale;
      const above = (height / 2 - y - high / 2) * this.scale;
      this.origins.push(right.clone().multiplyScalar(across).addScaledVector(up, above).sub(middle));
    }
    this.wake();
  }

  /** Sets the joints of the arms. An arm without joints is not drawn, since its pose is unknown. */
  setJoints(joints: ReadonlyArray<Joints | null>): void {
    const before = this.targets;
    this.targets = joints.map((one) => [...(one ?? [])]);
    if (
      this.targets.every(
        (one, arm) => one.length === before[arm]?.length && one.every((value, joint) => value === before[arm]?.[joint]),
      )
    )
      return;
    this.from = this.targets.map((one, arm) => [...(before[arm]?.length ? (this.shown[arm] ?? one) : one)]);
    this.movedAt = performance.now();
    this.wake();
  }

  end(): void {
    cancelAnimationFrame(this.frame);
    for (const { mesh } of this.parts) {
      if (mesh === null) continue;
      disposeOf(mesh);
      mesh.dispose();
    }
    this.renderer.dispose();
    this.renderer.forceContextLoss();
    this.renderer.domElement.remove();
  }

  private wake(): void {
    if (this.frame === 0) this.frame = requestAnimationFrame(() => this.draw());
  }

  private draw(): void {
    this.frame = 0;
    const began = performance.now();
    const share = Math.min(1, (began - this.movedAt) / GLIDE_DURATION);
    const count = Math.min(this.most, this.origins.length, this.targets.length);
    for (let arm = 0; arm < count; arm++) {
      const [from, to] = [this.from[arm] ?? [], this.targets[arm] ?? []];
      const now = (this.shown[arm] ??= []);
      for (let joint = 0; joint < JOINT_NAMES.length; joint++)
        now[joint] = (from[joint] ?? 0) + ((to[joint] ?? 0) - (from[joint] ?? 0)) * share;
      this.pose(arm, now, to.length > 0);
    }
    for (const { mesh } of this.parts) {
      if (mesh === null) continue;
      mesh.count = count;
      mesh.instanceMatrix.needsUpdate = true;
    }
    this.renderer.render(this.scene, this.camera);
    this.onDrawn(performance.now() - began);
    if (share < 1) this.wake();
  }

  private pose(arm: number, joints: readonly number[], isSeen: boolean): void {
    this.parts.forEach(({ mesh, parent, axis, at, joint, sign }, nth) => {
      const frame = this.frames[nth];
      const origin = this.origins[arm];
      if (frame === undefined || origin === undefined) return;
      const value = joint < 0 ? 0 : sign * (joints[joint] ?? 0);
      const rail = JOINT_NAMES[joint] === "l";
      this.step
        .makeRotationFromQuaternion(this.turn.setFromAxisAngle(axis, rail ? 0 : value * RADIANS))
        .setPosition(at);
      const base = this.frames[parent];
      if (base === undefined) frame.makeTranslation(origin).multiply(this.step);
      else frame.multiplyMatrices(base, this.step);
      mesh?.setMatrixAt(arm, isSeen ? frame : this.placed.makeScale(0, 0, 0));
    });
  }
}
