// The camera: a person turns it, a view sets it, and it shows what it is told to see.
import { PerspectiveCamera, Vector3 } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { directionOf, placeOf, type View } from "./camera";
import type { Point } from "./solid";

/** A flight from one place to another takes this long, ms. */
const FLIES = 350;
/** From this elevation on the picture is one from above, degrees. */
const ABOVE = 75;
/** In one frame a camera that follows the tip comes nearer to it by this share of the way. */
const FOLLOWS = 0.12;

interface Flight {
  from: Vector3;
  to: Vector3;
  target: Vector3;
  aim: Vector3;
  since: number;
}

export class Eye {
  readonly camera = new PerspectiveCamera(30, 1, 20, 6000);
  readonly controls: OrbitControls;
  /** The person has turned the picture by hand. */
  onTaken: () => void = () => {};
  /** The share of the picture's lower part that buttons cover. */
  covers: () => number = () => 0;
  /** What has to be seen, and how far to one side the work is. */
  sights: () => { points: readonly Point[]; side: number } = () => ({ points: [], side: 0 });
  private flight: Flight | null = null;
  private view: View = "corner";
  /** The person has turned, moved or zoomed the picture: it stays as they have it. */
  private isTurned = false;
  private follows = false;

  constructor(
    canvas: HTMLCanvasElement,
    /** Asked for less motion: no flights. */
    private readonly still: MediaQueryList,
    private readonly wake: () => void,
  ) {
    this.camera.up.set(0, 0, 1);
    const { camera } = this;
    this.controls = new OrbitControls(camera, canvas);
    this.controls.enableDamping = !still.matches;
    this.controls.dampingFactor = 0.15;
    this.controls.minDistance = 150;
    this.controls.maxDistance = 3000;
    this.controls.addEventListener("change", wake);
    let from = new Vector3();
    this.controls.addEventListener("start", () => {
      this.flight = null;
      from = camera.position.clone();
    });
    // A press alone turns nothing.
    this.controls.addEventListener("end", () => {
      if (from.distanceTo(camera.position) < 1) return;
      this.isTurned = true;
      this.onTaken();
    });
  }

  /** From this side, with all that has to be seen. */
  look(view: View, atOnce = false): void {
    this.view = view;
    this.isTurned = false;
    this.fly(view, atOnce);
  }

  /** All that has to be seen, from where the person looks. */
  fit(): void {
    this.fly(null, false);
  }

  /** Looks anew, as there is something else to see or another place for it: not where a person has turned the picture. */
  arrange(atOnce: boolean): void {
    if (!this.isTurned && !this.follows) this.fly(this.view, atOnce);
  }

  /** Nearer by this factor; the middle of the picture stays. */
  zoom(by: number): void {
    const { target, minDistance, maxDistance } = this.controls;
    this.isTurned = true;
    const goal = this.flight?.to ?? this.camera.position;
    const aim = this.flight?.aim ?? target;
    const away = goal.clone().sub(aim);
    away.setLength(Math.min(maxDistance, Math.max(minDistance, away.length() / by)));
    this.go(aim.clone().add(away), aim.clone(), false);
  }

  setFollow(follows: boolean): void {
    this.follows = follows;
    if (!follows) this.fly(this.isTurned ? null : this.view, false);
    this.wake();
  }

  /** How steeply it looks down, degrees. */
  elevation(): number {
    const { x, y, z } = this.camera.position.clone().sub(this.controls.target);
    return (Math.atan2(z, Math.hypot(x, y)) * 180) / Math.PI;
  }

  isAbove(): boolean {
    return this.elevation() > ABOVE;
  }

  setSize(width: number, height: number): void {
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
  }

  /** Goes on with its flight, or after the tip; whether that goes on. */
  step(tip: Vector3, now: number): boolean {
    const goesOn = this.flight !== null && this.flies(this.flight, now);
    const { target } = this.controls;
    if (!this.follows || tip.distanceTo(target) < 0.5) return goesOn;
    const by = tip
      .clone()
      .sub(target)
      .multiplyScalar(this.still.matches ? 1 : FOLLOWS);
    target.add(by);
    this.camera.position.add(by);
    return true;
  }

  private fly(view: View | null, atOnce: boolean): void {
    const { points, side } = this.sights();
    if (points.length === 0) return;
    const { x, y, z } = this.camera.position.clone().sub(this.controls.target).normalize();
    const direction: Point = view === null ? [x, y, z] : directionOf(view, side);
    const { position, target } = placeOf(points, direction, this.camera.fov, this.camera.aspect, this.covers());
    this.go(new Vector3(...position), new Vector3(...target), atOnce);
  }

  private go(to: Vector3, aim: Vector3, atOnce: boolean): void {
    if (atOnce || this.still.matches) {
      this.camera.position.copy(to);
      this.controls.target.copy(aim);
      this.flight = null;
    } else {
      const { target } = this.controls;
      this.flight = { from: this.camera.position.clone(), to, target: target.clone(), aim, since: performance.now() };
    }
    this.wake();
  }

  /** Goes round the arm and not through it. */
  private flies({ from, to, target, aim, since }: Flight, now: number): boolean {
    const share = Math.min(1, (now - since) / FLIES);
    const eased = 1 - (1 - share) ** 3;
    this.controls.target.lerpVectors(target, aim, eased);
    const length = from.distanceTo(target) * (1 - eased) + to.distanceTo(aim) * eased;
    const direction = from.clone().sub(target).normalize().lerp(to.clone().sub(aim).normalize(), eased);
    this.camera.position.copy(direction.setLength(length)).add(this.controls.target);
    if (share >= 1) this.flight = null;
    return share < 1;
  }
}
