import { beforeEach, expect, test, vi } from "vitest";
import type { State } from "../api";
import type { ArmEntry } from "../store";

vi.mock("../session", () => ({
  call: async () => ({ options: [] }),
  notificationListeners: new Set(),
  shownArm: () => ({ arm: "arm" }),
  sendOnClose: () => {},
}));
const store = await import("../store");
const { isArmed } = await import("./burn");
const { benches } = await import("./bench");
const check = await import("./check");
const { watchArmed } = await import("./laser");
const bench = benches.laser;

beforeEach(() => {
  store.socket.value = "up";
  store.role.value = "teacher";
  store.session.value = "me";
  store.armName.value = "arm";
  store.arms.value = [{ name: "arm", virtual: true, holder: { session: "me" } }] as unknown as ArmEntry[];
  store.state.value = { link: "up", arm: "arm", tool: { name: "laser", laser: false } } as unknown as State;
  check.openWorkshop.value = bench;
});

test("arming the laser is for the shown drawing and power alone", () => {
  const end = watchArmed();
  const changes = [
    () => bench.addText("Hello"),
    () => bench.write("Hello!"),
    () => bench.setValue("power", "90"),
    () => bench.color(1, "#ff0000"),
    () => bench.undo(),
    () => void (check.openWorkshop.value = check.runWorkshop),
  ];
  for (const change of changes) {
    isArmed.value = true;
    change();
    expect(isArmed.value).toBe(false);
  }
  check.openWorkshop.value = bench;
  isArmed.value = true;
  bench.choose(null);
  expect(isArmed.value).toBe(true);
  end();
});
