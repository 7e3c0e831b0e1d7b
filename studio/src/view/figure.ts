// Figure of the arm that can be posed: links, rods, tool, laser beam, and the axes at its tip.
import { Group, Mesh, MeshBasicMaterial, MeshLambertMaterial, MeshPhongMaterial, Vector3 } from "three";
import type { Model } from "../store";
import { ACCENT, bodyOf, JAWS, type Link, measuresOf, type Part, RODS, type ToolName, toolOf } from "./body";
import { disposeOf, merged } from "./mesh";
import { lathe, moved, plate } from "./solid";

export type Joint = "j1" | "j2" | "j3" | "j4" | "rail";
export type Joints = Record<Joint, number>;
export type Gripper = "open" | "closed" | "off";

/** Links that remain opaque, since they stand behind the drawing. */
const OPAQUE_LINKS = ["base", "turret"];
/** Length of the axes at the tip, mm. */
const AXIS_LENGTH = 26;
const BEAM_COLOR = "#6a48ff";
/** Share of its opening that the gripper closes in one frame. */
const JAW_SHARE = 0.18;

const BALL_PROFILE: ReadonlyArray<readonly [number, number]> = [
  [0.1, -2.6],
  [1.9, -1.8],
  [2.6, 0],
  [1.9, 1.8],
  [0.1, 2.6],
];
const rod = (from: number, to: number, radius: number) =>
  lathe([
    [radius, from],
    [radius, to],
  ]);

export class Figure {
  readonly root = new Group();
  /** Tip of the tool, with the tool's orientation. */
  tip = new Group();
  private joints: Array<{ group: Group; link: Link; joint: Joint; sign: number; at: Vector3 }> = [];
  private readonly opaqueMaterial = new MeshPhongMaterial({ vertexColors: true, specular: 0x30343a, shininess: 28 });
  private readonly fadingMaterial = new MeshPhongMaterial({ vertexColors: true, specular: 0x30343a, shininess: 28 });
  /**
   * Material of the depth pass: a copy of each link writes only the depth buffer, so that only the
   * front surface of a translucent arm is visible.
   */
  private readonly depthMaterial = new MeshBasicMaterial({ colorWrite: false, transparent: true });
  private readonly fading: Mesh[] = [];
  private readonly depthMeshes: Mesh[] = [];
  private readonly beam = new Group();
  private readonly axes = new Mesh();
  private jaws: Array<{ group: Group; sign: number }> = [];
  private opening: number = JAWS.off;
  private targetOpening: number = JAWS.off;
  private opacity = 1;

  /**
   * Builds the arm with a tool. `lift` is the distance of the tip below the wrist in addition to
   * the tool's own bias.
   */
  build(model: Model, tool: ToolName | null, lift: number): void {
    this.clear();
    const measures = measuresOf(model);
    const hang = lift - measures.tool[2];
    const parts = [...bodyOf(measures, hang, tool === "suction"), ...toolOf(tool, hang)];
    const groups = new Map<string, Group>();
    this.root.position.z = lift;
    for (const link of [...model.links, ...RODS]) {
      const group = new Group();
      const at = new Vector3().fromArray(link.at);
      if (link.name === "tool") {
        at.z -= lift;
        this.tip = group;
      }
      group.position.copy(at);
      (groups.get(link.parent ?? "") ?? this.root).add(group);
      groups.set(link.name, group);
      if (link.joint !== null) {
        const name = link.joint.replace("-", "");
        const joint = (name === "l" ? "rail" : name) as Joint;
        this.joints.push({ group, link, joint, sign: link.joint.startsWith("-") ? -1 : 1, at });
      }
    }
    for (const [link, sign] of [
      ["jaw_left", 1],
      ["jaw_right", -1],
    ] as const) {
      const group = new Group();
      this.tip.add(group);
      groups.set(link, group);
      this.jaws.push({ group, sign });
    }
    for (const [name, group] of groups) {
      const own = parts.filter(({ link }) => link === name);
      if (own.length > 0) this.addParts(group, own, OPAQUE_LINKS.includes(name));
    }
    this.addTipMarks();
    this.setOpacity(this.opacity, true);
    this.moveJaws(0);
  }

  private addParts(group: Group, parts: readonly Part[], isFirm: boolean): void {
    const mesh = new Mesh(merged(parts), isFirm ? this.opaqueMaterial : this.fadingMaterial);
    mesh.castShadow = mesh.receiveShadow = true;
    group.add(mesh);
    if (isFirm) return;
    const twin = new Mesh(mesh.geometry, this.depthMaterial);
    [twin.renderOrder, mesh.renderOrder] = [1, 2];
    group.add(twin);
    this.fading.push(mesh);
    this.depthMeshes.push(twin);
  }

  /** Builds the marks at the tip: axes and the laser beam. */
  private addTipMarks(): void {
    this.axes.geometry = merged([
      { color: "#e5484d", solid: plate("yz", [[0, 0, 0.8]], 2, AXIS_LENGTH, 0.2) },
      {
        color: "#2f9e64",
        solid: lathe(
          [
            [0.8, 2],
            [0.8, AXIS_LENGTH],
          ],
          "y",
        ),
      },
      { color: "#3b82f6", solid: rod(2, AXIS_LENGTH, 0.8) },
      { color: ACCENT, solid: lathe(BALL_PROFILE) },
    ]);
    this.axes.material = new MeshBasicMaterial({ vertexColors: true, depthTest: false, transparent: true });
    this.axes.renderOrder = 4;
    const light = (color: string, solid: number[], opacity: number) => {
      const look = { color, opacity, transparent: true, depthWrite: false };
      const mesh = new Mesh(merged([{ color, solid }]), new MeshBasicMaterial(look));
      mesh.renderOrder = 3;
      return mesh;
    };
    const [core, halo] = [light(BEAM_COLOR, rod(0, 1, 0.9), 1), light(BEAM_COLOR, rod(0, 1, 2.8), 0.28)];
    const [spot, ember] = [light("#fff1c9", rod(0.2, 0.8, 2), 1), light("#ff7a29", rod(0, 0.3, 6.5), 0.5)];
    for (const part of [core, halo]) part.name = "ray";
    this.beam.add(halo, core, ember, spot);
    this.beam.visible = false;
    this.tip.add(this.axes, this.beam);
  }

  pose(joints: Joints): void {
    for (const { group, link, joint, sign, at } of this.joints) {
      const axis = new Vector3().fromArray(link.axis);
      const value = sign * joints[joint];
      if (joint === "rail") group.position.copy(at).addScaledVector(axis, value);
      else group.quaternion.setFromAxisAngle(axis, (value * Math.PI) / 180);
    }
  }

  /** Shows the beam from the laser down to a surface `below` its tip, mm; null hides it. */
  showBeam(below: number | null): void {
    this.beam.visible = below !== null;
    // The upward axis would coincide with the beam.
    this.axes.visible = below === null;
    if (below === null) return;
    this.beam.position.z = -below;
    for (const part of this.beam.children) if (part.name === "ray") part.scale.z = 19 + below;
  }

  /** Sets the gripper's target opening; `width` is that of the held object, mm. */
  setGripper(gripper: Gripper | null, width: number | null): void {
    this.targetOpening =
      gripper === "closed" && width !== null ? Math.min(JAWS.open, width / 2) : JAWS[gripper ?? "off"];
  }

  /** Moves the jaws by a share of the remaining distance. Returns true if they still move. */
  moveJaws(share = JAW_SHARE): boolean {
    const left = this.targetOpening - this.opening;
    this.opening = Math.abs(left) < 0.2 || share >= 1 ? this.targetOpening : this.opening + left * share;
    for (const { group, sign } of this.jaws) group.position.y = sign * this.opening;
    return this.opening !== this.targetOpening && this.jaws.length > 0;
  }

  /** Sets the opacity of the parts that can hide the drawing; 1 is opaque. */
  setOpacity(opacity: number, anew = false): void {
    if (opacity === this.opacity && !anew) return;
    const isFaint = opacity < 1;
    if (isFaint !== this.fadingMaterial.transparent) {
      this.fadingMaterial.transparent = isFaint;
      this.fadingMaterial.needsUpdate = true;
    }
    this.opacity = this.fadingMaterial.opacity = opacity;
    for (const mesh of this.fading) mesh.castShadow = !isFaint;
    for (const twin of this.depthMeshes) twin.visible = isFaint;
  }

  /** Translucent tool for the target position. */
  ghost(model: Model, tool: ToolName | null, lift: number): Group {
    const hang = lift - measuresOf(model).tool[2];
    const parts = toolOf(tool, hang).map(({ link, color, solid }) => {
      const sign = { jaw_left: 1, jaw_right: -1 }[link] ?? 0;
      return { color, solid: moved(solid, [0, sign * JAWS.off, 0]) };
    });
    const geometry = merged([...parts, { color: ACCENT, solid: rod(hang - 19, hang - 11.5, 15) }]);
    const look = { color: ACCENT, transparent: true };
    const twin = new Mesh(geometry, new MeshBasicMaterial({ ...look, colorWrite: false }));
    const mesh = new Mesh(geometry, new MeshLambertMaterial({ ...look, opacity: 0.45 }));
    [twin.renderOrder, mesh.renderOrder] = [2, 3];
    return new Group().add(twin, mesh);
  }

  /** Disposes of the arm's parts. three.js uploads the shared materials again for the next arm. */
  clear(): void {
    disposeOf(this.axes);
    disposeOf(this.beam);
    this.beam.clear();
    for (const child of [...this.root.children]) disposeOf(child);
    this.joints = [];
    this.jaws = [];
    this.fading.length = this.depthMeshes.length = 0;
  }
}
