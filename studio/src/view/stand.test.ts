import { expect, test } from "vitest";
import { mountedOf } from "./mounted";
import { standOn, supportOf } from "./stand";
import { mutedColor } from "./tint";

const SHOULDER = 138;
test("the base stands on the table, a sheet's thickness below what the tip touches", () => {
  expect(standOn(-60, SHOULDER)).toEqual({ lift: 76, floor: -62, surface: -60 });
  expect(standOn(null, SHOULDER)).toEqual(standOn(-60, SHOULDER));
});

test("the length of a tool is clamped, and the floor stays below the table", () => {
  expect(standOn(-130, SHOULDER).lift).toBe(48);
  expect(standOn(-130, SHOULDER).floor).toBe(-132);
  expect(standOn(40, SHOULDER).lift).toBe(110);
  expect(standOn(40, SHOULDER).floor).toBe(-28);
  // A bias in z is part of the tool's length.
  expect(standOn(-130, SHOULDER, 20).lift).toBe(28);
});

test("the support of a point is the highest top that is not above it", () => {
  const belt = { at: [260, 0], size: [600, 80], turn: 90, top: -30 };
  expect(supportOf([260, 200, -30], [belt], -60)).toBe(-30);
  expect(supportOf([200, 200, -30], [belt], -60)).toBe(-60);
  expect(supportOf([260, 0, -50], [belt], -60)).toBe(-60);
});

const tool = { name: "suction", bias: null, suction: null, gripper: null, laser: null } as const;
test("the mounted tool is the one that draws, else the one switched, else the one configured", () => {
  expect(mountedOf(tool, "pen")).toBe("pen");
  expect(mountedOf(tool, null)).toBe("suction");
  expect(mountedOf({ ...tool, gripper: "open" }, null)).toBe("gripper");
  expect(mountedOf({ ...tool, gripper: "off" }, null)).toBe("suction");
  expect(mountedOf({ ...tool, gripper: "closed", suction: true }, null)).toBe("suction");
  expect(mountedOf({ ...tool, name: "laser", gripper: "closed" }, null)).toBe("laser");
  expect(mountedOf({ ...tool, name: null }, undefined)).toBe(null);
});

test("glaring colours are softened, others are kept", () => {
  expect(mutedColor("#ff0000")).toBe("#d8544f");
  expect(mutedColor("#00a000")).toBe("#46a671");
  expect(mutedColor("#0000ff")).toBe("#4479d4");
  expect(mutedColor("#c08070")).toBe("#c08070");
  expect(mutedColor("#808080")).toBe("#808080");
  expect(mutedColor("--belt")).toBe("--belt");
});
