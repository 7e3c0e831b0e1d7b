import { expect, test } from "vitest";
import { gripPosition, heldAfter, pickRows, placeRows, type WorldObject } from "./objects";

const cube = (name: string, at: number[], side = 25): WorldObject => ({
  name,
  at,
  size: [side, side, side],
  turn: 0,
  color: "#ff0000",
  held: false,
});
const NAMES = { above: (name: string) => `above ${name}`, on: (name: string) => `on ${name}` };
const red = cube("red cube", [220, 60, -60]);
const blue = cube("blue cube", [230, -40, -60], 20);

test("the cup holds an object at its top, the gripper at its middle", () => {
  expect(gripPosition(red, "suction")).toEqual([220, 60, -35]);
  expect(gripPosition(red, "gripper")).toEqual([220, 60, -47.5]);
});

test("a pick approaches from above, waits at the grip and leaves upwards", () => {
  const [above, on, up] = pickRows(red, "suction", 0.5, 0, NAMES);
  expect(above?.motion?.move).toEqual([220, 60, 5, 0]);
  expect(on).toMatchObject({ motion: { move: [220, 60, -35, 0], by: "line" }, suction: true, wait: 0.5 });
  expect(up?.motion).toMatchObject({ move: [220, 60, 5, 0], by: "line" });
});

test("a gripper opens before it descends", () => {
  expect(pickRows(red, "gripper", 0.5, 0, NAMES).map(({ gripper }) => gripper)).toEqual(["open", "close", null]);
});

test("an object put on another stands on it", () => {
  const [, on] = placeRows(blue, red, "suction", 0.5, 0, NAMES);
  // The top of the blue cube is at -40, and the red cube extends 25 below the cup.
  expect(on?.motion?.move).toEqual([230, -40, -15, 0]);
  expect(on).toMatchObject({ suction: false, wait: 0.5 });
  const [, gripped] = placeRows(blue, red, "gripper", 0.5, 0, NAMES);
  expect(gripped?.motion?.move).toEqual([230, -40, -27.5, 0]);
});

test("the held object is determined by the rows, else by the world", () => {
  const rows = [...pickRows(red, "suction", 0.5, 0, NAMES), ...placeRows(blue, red, "suction", 0.5, 0, NAMES)];
  expect(heldAfter(rows, 0, [red, blue])).toBeNull();
  expect(heldAfter(rows, 2, [red, blue])?.name).toBe("red cube");
  expect(heldAfter(rows, rows.length - 1, [red, blue])).toBeNull();
  expect(heldAfter([], -1, [red, { ...blue, held: true }])?.name).toBe("blue cube");
});
