import { beforeEach, expect, test, vi } from "vitest";
import type { Report, State } from "../api";
import type { ArmEntry } from "../store";

const asked: string[] = [];
const measured = { touches: 0, plane: { at: [200, 0], z: -45, slope_x: 0, slope_y: 0 }, corners: [], sheet: null };
let surface: unknown = measured;
vi.mock("../session", () => ({
  call: async (method: string, params: { forget?: boolean }) => {
    asked.push(params.forget ? `${method} forget` : method);
    if (method === "world.scenario") store.state.value = { ...store.state.value, homed: false } as State;
    if (method === "surface.touch") surface = { ...measured, plane: null };
    if (method.startsWith("surface")) return surface;
    if (method === "arm.home") throw new Error("is not waited for");
    return { objects: [], scenarios: [] };
  },
  notificationListeners: new Set(),
  shownArm: () => ({ arm: "arm" }),
}));
const store = await import("../store");
const { loadScenario: begin } = await import("./world");
const { heightAboveTable: inAir } = await import("../run/paper");

beforeEach(() => {
  asked.length = 0;
  surface = measured;
  store.armName.value = "arm";
  store.arms.value = [{ name: "arm", virtual: true }] as unknown as ArmEntry[];
  store.state.value = { link: "up", homed: true } as State;
});

test("loading a scenario forgets the measured surface", async () => {
  await begin("x", false);
  expect(asked.filter((one) => !one.startsWith("world.look"))).toEqual([
    "world.scenario",
    "surface.get",
    "surface.touch forget",
  ]);
  asked.length = 0;
  await begin("x", false);
  expect(asked).not.toContain("surface.touch forget");
});

test("loading a scenario homes the arm again only if it was homed", async () => {
  await begin("x");
  expect(asked).toContain("arm.home");
  asked.length = 0;
  store.state.value = { link: "up", homed: false } as State;
  await begin("x");
  expect(asked).not.toContain("arm.home");
});

test("a pen that would not touch the table of a virtual arm draws in the air", () => {
  const report = (height: number) =>
    ({ placed: {}, preview: { strokes: [{ height }], travels: [] } }) as unknown as Report;
  const around = { table: { height: -60 }, draws: "pen" } as never;
  expect(inAir(report(-45), "pen", around)).toBe(15);
  expect(inAir(report(-60), "pen", around)).toBe(null);
  expect(inAir(report(-45), "laser", around)).toBe(null);
  expect(inAir(report(-45), "pen", null)).toBe(null);
  expect(inAir({ ...report(-45), placed: undefined } as unknown as Report, "pen", around)).toBe(null);
  store.arms.value = [{ name: "arm", virtual: false }] as unknown as ArmEntry[];
  expect(inAir(report(-45), "pen", around)).toBe(null);
});

test("manual moves and jobs are refused while the arm homes", () => {
  store.socket.value = "up";
  store.role.value = "teacher";
  store.session.value = "me";
  store.arms.value = [{ name: "arm", virtual: true, holder: { session: "me" } }] as unknown as ArmEntry[];
  expect(store.why.value).toBe(null);
  store.homing.value = "arm";
  expect(store.why.value).toBe("why.homing");
  store.homing.value = "another";
  expect(store.why.value).toBe(null);
});
