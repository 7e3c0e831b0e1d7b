import { expect, test } from "vitest";
import { bodyOf, type Link, RODS, toolOf } from "./body";
import { normalsOf, type Point, volumeOf } from "./solid";

const [REAR, FORE] = [135, 147];
const Y = [0, 1, 0];
const CHAIN: readonly Link[] = [
  { name: "turret", parent: null, joint: "j1", axis: [0, 0, 1], at: [0, 0, 0] },
  { name: "rear_arm", parent: "turret", joint: "j2", axis: Y, at: [0, 0, 0] },
  { name: "elbow", parent: "rear_arm", joint: "-j2", axis: Y, at: [0, 0, REAR] },
  { name: "forearm", parent: "elbow", joint: "j3", axis: Y, at: [0, 0, 0] },
  { name: "wrist", parent: "forearm", joint: "-j3", axis: Y, at: [FORE, 0, 0] },
  ...RODS,
];
type Joints = Record<string, number>;

/**
 * Position of a link's point in the frame of the turret. All joints beyond the turret turn about y.
 */
function placed(name: string, point: Point, joints: Joints): Point {
  const link = CHAIN.find((one) => one.name === name);
  if (link === undefined || link.name === "turret") return point;
  const angle = ((joints[link.joint?.replace("-", "") ?? ""] ?? 0) * Math.PI) / 180;
  const by = link.joint?.startsWith("-") ? -angle : angle;
  const [x, y, z] = point;
  const turned: Point = [x * Math.cos(by) + z * Math.sin(by), y, -x * Math.sin(by) + z * Math.cos(by)];
  const [ax = 0, ay = 0, az = 0] = link.at;
  return placed(link.parent ?? "", [turned[0] + ax, turned[1] + ay, turned[2] + az], joints);
}

const near = (one: Point, other: Point) =>
  one.forEach((value, axis) => expect(value).toBeCloseTo(other[axis] ?? NaN, 9));

test.each([
  [45, 45],
  [0, -10],
  [85, 60],
  [10, 70],
])("every rod ends at its other pin at J2 %d and J3 %d", (j2, j3) => {
  const joints = { j2, j3 };
  const at = (name: string): Point => {
    const [x = 0, y = 0, z = 0] = RODS.find((rod) => rod.name === name)?.at ?? [];
    return [x, y, z];
  };
  near(placed("level_rod", [0, 0, REAR], joints), placed("elbow", at("level_rod"), joints));
  near(placed("head_rod", [FORE, 0, 0], joints), placed("wrist", at("head_rod"), joints));
  // The crank's rod ends at the rear end of the forearm.
  near(placed("drive_rod", [0, 0, REAR], joints), placed("forearm", at("crank_pin"), joints));
});

const measures = { rear: REAR, fore: FORE, half: 79, base: 78, turret: 60, tool: [59.7, 0, 0] } as const;

test("every solid of arm and tools is closed with faces outwards", () => {
  const tools = (["none", "suction", "gripper", "pen", "laser", null] as const).flatMap((name) => toolOf(name, 78));
  for (const { link, solid } of [...bodyOf(measures, 78, true), ...tools]) {
    expect(volumeOf(solid), link).toBeGreaterThan(0);
    expect(normalsOf(solid).every(Number.isFinite), link).toBe(true);
  }
});

test.each(["none", "suction", "pen"] as const)("the tip of %s is the origin of its frame", (name) => {
  const lowest = toolOf(name, 78).flatMap(({ solid }) => solid.filter((_, nth) => nth % 3 === 2));
  expect(Math.min(...lowest)).toBeCloseTo(0, 5);
});

test("the base stands on the floor and the hose is there only with the cup", () => {
  const heights = (link: string) =>
    bodyOf(measures, 78, false)
      .filter((part) => part.link === link)
      .flatMap(({ solid }) => solid.filter((_, nth) => nth % 3 === 2));
  expect(Math.min(...heights("base"))).toBeCloseTo(-measures.base);
  const count = (hasHose: boolean) => bodyOf(measures, 78, hasHose).length;
  expect(count(true)).toBe(count(false) + 2);
});
