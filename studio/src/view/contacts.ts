// Objects on the table: a carried object moves with the tool, and each casts a soft shadow on what
// is below it.
import { Group, type Mesh, type MeshBasicMaterial, Vector3 } from "three";
import type { State } from "../api";
import { softShadow } from "./ground";
import type { Shapes } from "./layers";
import { disposeOf } from "./mesh";
import type { Point } from "./solid";
import { type Support, supportOf } from "./stand";

/** Shadow of an object. It fades out with the height above the table, mm. */
const SHADOW = { blur: 12, opacity: 0.5, fades: 90 };
const UP = new Vector3(0, 0, 1);

/** Carried object: its position relative to the tip, in the tool's axes. */
interface CarriedObject {
  offset: Vector3;
  turn: number;
}

export class Contacts {
  readonly group = new Group();
  private readonly carried = new Map<string, CarriedObject>();
  private meshes: readonly Mesh[] = [];
  private belts: Shapes["boxes"] = [];

  /** Accepts the objects of a new reading of the world. */
  update(things: readonly Mesh[], belts: Shapes["boxes"], state: State | null): void {
    [this.meshes, this.belts] = [things, belts];
    for (const child of [...this.group.children]) disposeOf(child);
    const carried = new Set<string>();
    for (const mesh of things) {
      const { name, size, held, turn } = mesh.userData as { name: string; size: Point; held: boolean; turn?: number };
      const shadow = softShadow(size[0], size[1], SHADOW.blur, SHADOW.opacity);
      shadow.userData.of = mesh;
      this.group.add(shadow);
      if (!held || state === null) continue;
      carried.add(name);
      const { x, y, z, r, moving } = state;
      // The pose and the world are read at different times, so their difference is wrong during
      // motion.
      if (moving && this.carried.has(name)) continue;
      const angle = (-r * Math.PI) / 180;
      const offset = moving
        ? new Vector3(0, 0, -size[2])
        : mesh.position
            .clone()
            .sub(new Vector3(x, y, z))
            .applyAxisAngle(UP, angle);
      this.carried.set(name, { offset, turn: ((turn ?? 0) * Math.PI) / 180 + angle });
    }
    for (const name of [...this.carried.keys()]) if (!carried.has(name)) this.carried.delete(name);
  }

  /** Moves carried objects to the tip, and every shadow below its object. */
  carry(tip: Group, surface: number): void {
    const at = new Vector3().setFromMatrixPosition(tip.matrixWorld);
    const turn = Math.atan2(tip.matrixWorld.elements[1] ?? 0, tip.matrixWorld.elements[0] ?? 1);
    const supports = this.supports();
    for (const shadow of this.group.children as Mesh[]) {
      const mesh = shadow.userData.of as Mesh;
      const held = this.carried.get(String(mesh.userData.name));
      if (held !== undefined) {
        mesh.position.copy(held.offset).applyAxisAngle(UP, turn).add(at);
        mesh.rotation.z = held.turn + turn;
      }
      const { x, y, z } = mesh.position;
      const others = supports.filter(({ of }) => of !== mesh);
      const below = supportOf([x, y, z], others, surface);
      shadow.position.set(x, y, below + 0.4);
      shadow.rotation.z = mesh.rotation.z;
      const share = Math.max(0, 1 - (z - below) / SHADOW.fades);
      (shadow.material as MeshBasicMaterial).opacity = SHADOW.opacity * share;
    }
  }

  private supports(): Array<Support & { of: Mesh | null }> {
    return [
      ...this.belts.map((belt) => ({ ...belt, top: (belt.at[2] ?? 0) + (belt.size[2] ?? 0), of: null })),
      ...this.meshes.map((mesh) => {
        const size = mesh.userData.size as Point;
        const turn = (mesh.rotation.z * 180) / Math.PI;
        return { at: mesh.position.toArray(), size, turn, top: mesh.position.z + size[2], of: mesh };
      }),
    ];
  }
}
