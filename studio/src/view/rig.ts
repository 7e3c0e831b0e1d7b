// Camera: turned by the user, set by a view, and framed around given points.
import { PerspectiveCamera, Vector3 } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { directionOf, placeOf, type View } from "./camera";
import type { Point } from "./solid";

/** Duration of a flight between two positions, ms. */
const FLIGHT_DURATION = 350;
/** Elevation from which the picture counts as a view from above, degrees. */
const TOP_VIEW_ELEVATION = 75;
/** Share of the distance to the tip that a following camera covers in one frame. */
const FOLLOW_SHARE = 0.12;

interface Flight {
  from: Vector3;
  to: Vector3;
  target: Vector3;
  aim: Vector3;
  since: number;
}

export class CameraRig {
  readonly camera = new PerspectiveCamera(30, 1, 20, 6000);
  readonly controls: OrbitControls;
  /** Called when the user turns the picture. */
  onUserTurn: () => void = () => {};
  /** Share of the picture that buttons cover at the bottom. */
  coveredShare: () => number = () => 0;
  /** Points that must be visible, and the lateral position of the work. */
  visiblePoints: () => { points: readonly Point[]; side: number } = () => ({ points: [], side: 0 });
  private flight: Flight | null = null;
  private view: View = "corner";
  /** True after the user has turned, moved or zoomed the picture: automatic framing is then off. */
  private isTurned = false;
  private followsTip = false;

  constructor(
    canvas: HTMLCanvasElement,
    /** Media query for reduced motion, which turns flights off. */
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
    // A press without a drag does not count as turning.
    this.controls.addEventListener("end", () => {
      if (from.distanceTo(camera.position) < 1) return;
      this.isTurned = true;
      this.onUserTurn();
    });
  }

  /** Looks from a side, with all points in the picture. */
  look(view: View, atOnce = false): void {
    this.view = view;
    this.isTurned = false;
    this.flyToView(view, atOnce);
  }

  /** Frames all points from the current direction. */
  fit(): void {
    this.flyToView(null, false);
  }

  /**
   * Frames the picture again after its content or size has changed, unless the user has turned it.
   */
  reframe(atOnce: boolean): void {
    if (!this.isTurned && !this.followsTip) this.flyToView(this.view, atOnce);
  }

  /** Zooms by a factor around the centre. */
  zoom(by: number): void {
    const { target, minDistance, maxDistance } = this.controls;
    this.isTurned = true;
    const goal = this.flight?.to ?? this.camera.position;
    const aim = this.flight?.aim ?? target;
    const away = goal.clone().sub(aim);
    away.setLength(Math.min(maxDistance, Math.max(minDistance, away.length() / by)));
    this.startFlight(aim.clone().add(away), aim.clone(), false);
  }

  setFollow(follows: boolean): void {
    this.followsTip = follows;
    if (!follows) this.flyToView(this.isTurned ? null : this.view, false);
    this.wake();
  }

  /** Elevation of the camera, degrees. */
  elevation(): number {
    const { x, y, z } = this.camera.position.clone().sub(this.controls.target);
    return (Math.atan2(z, Math.hypot(x, y)) * 180) / Math.PI;
  }

  isAbove(): boolean {
    return this.elevation() > TOP_VIEW_ELEVATION;
  }

  setSize(width: number, height: number): void {
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
  }

  /** Advances the flight, or follows the tip. Returns true if the camera still moves. */
  step(tip: Vector3, now: number): boolean {
    const goesOn = this.flight !== null && this.advanceFlight(this.flight, now);
    const { target } = this.controls;
    if (!this.followsTip || tip.distanceTo(target) < 0.5) return goesOn;
    const by = tip
      .clone()
      .sub(target)
      .multiplyScalar(this.still.matches ? 1 : FOLLOW_SHARE);
    target.add(by);
    this.camera.position.add(by);
    return true;
  }

  private flyToView(view: View | null, atOnce: boolean): void {
    const { points, side } = this.visiblePoints();
    if (points.length === 0) return;
    const { x, y, z } = this.camera.position.clone().sub(this.controls.target).normalize();
    const direction: Point = view === null ? [x, y, z] : directionOf(view, side);
    const { position, target } = placeOf(points, direction, this.camera.fov, this.camera.aspect, this.coveredShare());
    this.startFlight(new Vector3(...position), new Vector3(...target), atOnce);
  }

  private startFlight(to: Vector3, aim: Vector3, atOnce: boolean): void {
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

  /** Flies around the arm instead of through it. */
  private advanceFlight({ from, to, target, aim, since }: Flight, now: number): boolean {
    const share = Math.min(1, (now - since) / FLIGHT_DURATION);
    const eased = 1 - (1 - share) ** 3;
    this.controls.target.lerpVectors(target, aim, eased);
    const length = from.distanceTo(target) * (1 - eased) + to.distanceTo(aim) * eased;
    const direction = from.clone().sub(target).normalize().lerp(to.clone().sub(aim).normalize(), eased);
    this.camera.position.copy(direction.setLength(length)).add(this.controls.target);
    if (share >= 1) this.flight = null;
    return share < 1;
  }
}
