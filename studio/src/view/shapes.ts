// Lines and boxes of a layer in 3D, and dragging of boxes.
import {
  BoxGeometry,
  BufferGeometry,
  type Camera,
  EdgesGeometry,
  Float32BufferAttribute,
  Group,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshLambertMaterial,
  type Object3D,
  Plane,
  Points,
  PointsMaterial,
  Raycaster,
  Vector2,
  Vector3,
} from "three";
import { type Lines, onObjectDragged, type Shapes } from "./layers";
import { solidGeometry } from "./mesh";
import { box as solidBox } from "./solid";
import { mutedColor } from "./tint";

export type Css = (color: string) => string;

/** Lines of one style are merged into one object, since a path may have many thousands. */
export function shapesOf({ lines, boxes }: Shapes, css: Css): Group {
  const group = new Group();
  const looks = new Map<string, Lines[]>();
  for (const line of lines) {
    const look = `${line.color} ${line.opacity} ${line.dots}`;
    const alike = looks.get(look);
    if (alike === undefined) looks.set(look, [line]);
    else alike.push(line);
  }
  for (const alike of looks.values()) {
    const [first] = alike;
    if (first === undefined) continue;
    const geometry = new BufferGeometry();
    const opacity = first.opacity ?? 1;
    const look = { color: css(first.color), opacity, transparent: opacity < 1 };
    geometry.setAttribute(
      "position",
      new Float32BufferAttribute(first.dots ? alike.flatMap(dots) : alike.flatMap(segments), 3),
    );
    group.add(
      first.dots
        ? new Points(geometry, new PointsMaterial({ ...look, size: 7, sizeAttenuation: false }))
        : new LineSegments(geometry, new LineBasicMaterial(look)),
    );
  }
  for (const box of boxes) {
    const [x = 0, y = 0, z = 0] = box.size;
    const isThing = box.name !== undefined;
    const geometry = isThing
      ? solidGeometry(solidBox([-x / 2, -y / 2, 0], [x / 2, y / 2, z], 1.6, 0.9))
      : new BoxGeometry(x, y, z).translate(0, 0, z / 2);
    const color = isThing ? mutedColor(css(box.color)) : css(box.color);
    const opacity = box.opacity ?? 1;
    const mesh = new Mesh(
      geometry,
      new MeshLambertMaterial({ color, opacity, transparent: opacity < 1, depthWrite: opacity === 1 }),
    );
    mesh.castShadow = opacity === 1;
    mesh.receiveShadow = true;
    if (opacity < 1)
      mesh.add(
        new LineSegments(
          new EdgesGeometry(geometry),
          new LineBasicMaterial({ color, transparent: true, opacity: 0.8 }),
        ),
      );
    mesh.position.fromArray([...box.at]);
    mesh.rotation.z = ((box.turn ?? 0) * Math.PI) / 180;
    mesh.userData = box;
    group.add(mesh);
  }
  return group;
}

const dots = (line: Lines) => line.points.flatMap(([x = 0, y = 0, z = 0]) => [x, y, z]);
function segments({ points, closed }: Lines): number[] {
  const all: number[] = [];
  for (let at = closed ? 0 : 1; at < points.length; at++) {
    for (const [x = 0, y = 0, z = 0] of [points.at(at - 1) ?? [], points[at] ?? []]) all.push(x, y, z);
  }
  return all;
}

/** Makes named boxes draggable in a horizontal plane. Returns a function that ends it. */
export function dragging(
  place: HTMLElement,
  camera: Camera,
  boxes: () => Group | undefined,
  turned: (is: boolean) => void,
  redraw: () => void,
): () => void {
  const ray = new Raycaster();
  const floor = new Plane(new Vector3(0, 0, 1));
  let held: { mesh: Object3D; from: Vector3; point: Vector3; pointer: number } | null = null;
  const aim = (event: PointerEvent) => {
    const { left, top, width, height } = place.getBoundingClientRect();
    ray.setFromCamera(
      new Vector2(((event.clientX - left) / width) * 2 - 1, 1 - ((event.clientY - top) / height) * 2),
      camera,
    );
  };
  const taken = () => {
    const [hit] = ray
      .intersectObjects(boxes()?.children ?? [], false)
      .filter(({ object }) => object.userData.name !== undefined);
    return onObjectDragged.value === null ? undefined : hit;
  };
  const down = (event: PointerEvent) => {
    if (event.target !== place.querySelector("canvas") || event.button !== 0) return;
    aim(event);
    const hit = taken();
    if (hit === undefined) return;
    held = { mesh: hit.object, from: hit.object.position.clone(), point: hit.point, pointer: event.pointerId };
    floor.constant = -hit.point.z;
    turned(false);
    place.setPointerCapture(event.pointerId);
    event.stopPropagation();
    event.preventDefault();
  };
  const move = (event: PointerEvent) => {
    if (held?.pointer !== event.pointerId) {
      aim(event);
      place.classList.toggle("grabs", event.buttons === 0 && taken() !== undefined);
      return;
    }
    aim(event);
    const to = ray.ray.intersectPlane(floor, new Vector3());
    if (to === null || to.length() > 700) return;
    held.mesh.position.copy(held.from).add(to.sub(held.point));
    redraw();
  };
  const up = (event: PointerEvent) => {
    if (held?.pointer !== event.pointerId) return;
    const { mesh, from } = held;
    held = null;
    turned(true);
    if (event.type === "pointerup" && !mesh.position.equals(from)) {
      onObjectDragged.value?.(String(mesh.userData.name), mesh.position.toArray());
    } else {
      mesh.position.copy(from);
      redraw();
    }
  };
  const over = new AbortController();
  const { signal } = over;
  place.addEventListener("pointerdown", down, { capture: true, signal });
  place.addEventListener("pointermove", move, { signal });
  for (const end of ["pointerup", "pointercancel"] as const) place.addEventListener(end, up, { signal });
  return () => over.abort();
}
