// Layer for the fence of the shown arm: the box it must not leave, and those it must not enter.
import { effect } from "@preact/signals";
import * as store from "../store";
import { type Box, show } from "./layers";

export type Sides = Record<string, [number, number]>;
/** Extent of a side that the fence does not limit, mm, beyond the reach of any arm. */
const OPEN_EXTENT = 420;

function boxOf(sides: Sides, color: string, opacity: number): Box {
  const side = (axis: string): [number, number] => {
    const [least, most] = sides[axis] ?? [-OPEN_EXTENT, OPEN_EXTENT];
    return [Math.max(-OPEN_EXTENT, least), Math.min(OPEN_EXTENT, most)];
  };
  const [x, y, z] = [side("x"), side("y"), side("z")];
  return {
    at: [(x[0] + x[1]) / 2, (y[0] + y[1]) / 2, z[0]],
    size: [x[1] - x[0], y[1] - y[0], z[1] - z[0]],
    color,
    opacity,
  };
}

effect(() => {
  const fence = store.fence.value;
  if (fence === null) return show("fence", []);
  const boxes = fence.keep_out.map((sides) => boxOf(sides, "--stop", 0.28));
  const box = fence.box;
  if (box !== null) boxes.push(boxOf(box, "--fence", 0.06));
  // The reachable space is above the floor, which is drawn as a sheet of the box's size.
  if (fence.floor !== null) boxes.push(boxOf({ ...box, z: [fence.floor - 1, fence.floor] }, "--fence", 0.22));
  show("fence", [], boxes);
});
