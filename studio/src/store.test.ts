import { beforeEach, expect, test } from "vitest";
import type { State } from "./api";
import * as store from "./store";

const heard = (laser: boolean, moving = false, arm = "a", link = "up") =>
  void (store.state.value = { arm, link, moving, tool: { laser } } as State);

beforeEach(() => {
  store.backend.value = "station";
  store.socket.value = "up";
  store.armName.value = "a";
  store.jobState.value = "none";
  heard(false);
});

test("a laser that was on when the connection was lost is unknown, not off", () => {
  heard(true);
  expect(store.laser.value).toBe("on");
  store.socket.value = "lost";
  expect(store.laser.value).toBe("unknown");
  store.socket.value = "closed";
  store.armName.value = null;
  store.state.value = null;
  expect(store.laser.value).toBe("unknown");
  store.socket.value = "up";
  store.armName.value = "a";
  heard(false);
  expect(store.laser.value).toBe("off");
  expect(store.lastActivity.value).toBeNull();
});

test("a lost link between station and arm counts as a lost connection", () => {
  heard(true);
  heard(true, false, "a", "lost");
  expect(store.laser.value).toBe("unknown");
});

test("a burning job counts as burning and moving between its lines", () => {
  store.jobState.value = "running";
  heard(true, true);
  heard(false, true);
  store.socket.value = "lost";
  expect(store.laser.value).toBe("unknown");
  expect(store.lastActivity.value).toEqual({ arm: "a", laser: true, isMoving: true });
});

test("no activity remains after a job, for another arm, or for the page's own arm", () => {
  store.jobState.value = "running";
  heard(true, true);
  store.jobState.value = "done";
  heard(false);
  store.socket.value = "lost";
  expect(store.lastActivity.value).toBeNull();
  store.socket.value = "up";
  heard(true);
  store.armName.value = "b";
  store.state.value = null;
  expect(store.lastActivity.value).toBeNull();
  store.backend.value = "sim";
  heard(true, false, "b");
  store.socket.value = "closed";
  expect(store.lastActivity.value).toBeNull();
});
