import { beforeEach, expect, test, vi } from "vitest";
import type { Job, State } from "../api";
import type { ArmEntry } from "../store";
import type { Order } from "./jobs";

const asked: string[] = [];
vi.mock("../session", () => ({
  call: async (method: string) => {
    asked.push(method);
    return { job: "new" };
  },
  notificationListeners: new Set(),
  shownArm: () => ({ arm: "arm" }),
  sendOnClose: () => {},
}));
const store = await import("../store");
const { isArmed, jobBurns, jobFrames, rememberJob: keep, mayBurn } = await import("./burn");
const jobs = await import("./jobs");

const job = (id: string) => ({ job: id, title: null, state: "stopped", holder: null }) as unknown as Job;
const mounted = (name: string) => {
  store.state.value = { link: "up", tool: { name, laser: false } } as unknown as State;
};
const SETUPS = [
  undefined,
  {},
  { raw: true },
  { tool: "pen" },
  { tool: "laser" },
  { tool: "laser", frame: "box" },
] as const;

beforeEach(() => {
  asked.length = 0;
  isArmed.value = false;
  store.socket.value = "up";
  store.role.value = "teacher";
  store.session.value = "me";
  store.armName.value = "arm";
  store.arms.value = [{ name: "arm", virtual: true, holder: { session: "me" } }] as unknown as ArmEntry[];
});

test("a setup burns by its tool, else by the tool of the arm, and a frame never does", () => {
  mounted("laser");
  expect(SETUPS.map(mayBurn)).toEqual([true, true, true, false, true, false]);
  mounted("pen");
  expect(SETUPS.map(mayBurn)).toEqual([false, false, false, false, true, false]);
});

test("no burning job starts or resumes while the laser is not armed", async () => {
  for (const tool of ["laser", "pen", "none"]) {
    mounted(tool);
    for (const armed of [false, true]) {
      for (const setup of SETUPS) {
        isArmed.value = armed;
        asked.length = 0;
        const burns = mayBurn(setup);
        const isLet = armed || !burns;
        expect(jobs.whyNotStart(setup as Order["setup"])).toBe(isLet ? null : "laser.unarmed");
        await jobs.start({ program: "x", setup: setup as Order["setup"] } as Order, "x", "");
        expect(asked.includes("job.start")).toBe(isLet);

        keep("old", setup);
        expect(jobs.whyNotResume(job("old"))).toBe(isLet ? null : "laser.unarmed");
        await jobs.resume(job("old"));
        expect(asked.includes("job.resume")).toBe(isLet);
      }
    }
  }
});

test("a job that only traces the outline is known as a frame, also after its end", () => {
  keep("round", { tool: "laser", frame: "box" });
  keep("burnt", { tool: "laser" });
  expect([jobFrames(job("round")), jobFrames(job("burnt")), jobFrames(job("unknown"))]).toEqual([true, false, false]);
});

test("a job of another page burns where the arm has a laser", () => {
  mounted("laser");
  expect(jobBurns(job("unknown"))).toBe(true);
  mounted("pen");
  expect(jobBurns(job("unknown"))).toBe(false);
});

test("jobs are started and resumed in one module, except by two that check the laser or burn nothing", () => {
  const sources = import.meta.glob("../**/*.{ts,tsx}", { query: "?raw", import: "default", eager: true });
  const doors = Object.entries(sources as Record<string, string>)
    .filter(([name, text]) => !/test\.ts$/.test(name) && /call\(\s*"job\.(start|resume)"/.test(text))
    .map(([name]) => name);
  expect(doors.toSorted()).toEqual(["../panels/first.tsx", "../site.ts", "./jobs.ts"]);
});

test("every button is disabled for a pupil while the arm is frozen", () => {
  mounted("pen");
  store.role.value = "student";
  expect(store.why.value).toBe(null);
  store.isFrozen.value = true;
  expect([store.why.value, jobs.whyNotStart(), jobs.whyNotResume(job("old"))]).toEqual(Array(3).fill("why.frozen"));
  store.role.value = "teacher";
  expect(store.why.value).toBe(null);
  store.isFrozen.value = false;
});

test("notices about an unreachable or frozen arm disappear once it can be moved", () => {
  for (const held of [store.isFrozen, store.socket] as const) {
    if (held === store.socket) held.value = "lost";
    else store.isFrozen.value = true;
    store.notify("refused", true);
    store.isFrozen.value = false;
    store.socket.value = "up";
    expect(store.notice.value).toBe(null);
  }
});

test("resuming another pupil's job needs confirmation, resuming one's own does not", async () => {
  mounted("pen");
  store.pupil.value = "Ben";
  const of = (name: string) => ({ ...job("theirs"), holder: { session: "other", name } }) as Job;
  for (const yes of [false, true]) {
    asked.length = 0;
    const resumed = jobs.resume(of("Ada"));
    expect(store.question.value?.title).toContain("Ada");
    store.question.value?.answer(yes);
    await resumed;
    expect(asked).toEqual(yes ? ["job.resume"] : []);
  }
  await jobs.resume(of("ben"));
  expect(asked).toEqual(["job.resume", "job.resume"]);
  store.pupil.value = null;
});

test.each(["{}", "[1]", '[["one","often"]]', "[["])(
  "damaged memory %s leaves the tool of the arm to decide",
  async (text) => {
    sessionStorage.setItem("magician.burns", text);
    vi.resetModules();
    const burn = await import("./burn");
    (await import("../store")).state.value = { link: "up", tool: { name: "laser", laser: false } } as unknown as State;
    expect(burn.jobBurns(job("one"))).toBe(true);
  },
);
