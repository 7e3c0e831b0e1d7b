import { afterEach, describe, expect, it, vi } from "vitest";
import type { Job } from "../api";
import * as jobs from "./jobs";
import { durationOf, isShown, isUneventful } from "./strip";

const job = (more: Partial<Job>): Job => ({
  job: "j1",
  arm: "arm",
  title: "house",
  state: "running",
  step: 0,
  steps: null,
  first_step: null,
  loops: 1,
  loop: 1,
  seconds_left: null,
  drawn_mm: null,
  travel_mm: null,
  started: null,
  ended: null,
  holder: null,
  part: null,
  reason: null,
  text: null,
  place: null,
  error: null,
  notes: null,
  digest: null,
  ...more,
});
const seen = new Set(["j1"]);

describe("the strip", () => {
  it("shows an active job of any client", () => {
    for (const state of ["checking", "running", "pausing", "paused", "stopping"] as const)
      expect(isShown(job({ state }), new Set(), null)).toBe(true);
  });

  it("shows the end of a job that was seen active, until it is dismissed", () => {
    expect(isShown(job({ state: "done" }), seen, null)).toBe(true);
    expect(isShown(job({ state: "done" }), seen, "j1")).toBe(false);
    expect(isShown(job({ state: "done" }), new Set(), null)).toBe(false);
    expect(isShown(job({ state: "running" }), seen, "j1")).toBe(true);
  });

  it("shows a job that was interrupted while no page was open", () => {
    expect(isShown(job({ state: "interrupted" }), new Set(), null)).toBe(true);
  });

  it("stays if there is something to read", () => {
    expect(isUneventful(job({ state: "done" }))).toBe(true);
    expect(isUneventful(job({ state: "stopped" }))).toBe(false);
    expect(isUneventful(job({ state: "done", notes: [{ code: "nothing-picked", text: "", template: "" }] }))).toBe(
      false,
    );
  });

  it("returns the duration of a job", () => {
    expect(durationOf(job({ started: 100, ended: 116.4 }))).toBeCloseTo(16.4);
    expect(durationOf(job({ started: null, ended: 116 }))).toBeNull();
  });

  it("shows a job that ended during a reload, until it is dismissed", async () => {
    const loaded = async (of: Job) => {
      vi.resetModules();
      const [jobs, strip] = [await import("./jobs"), await import("./strip")];
      const end = strip.follow();
      jobs.jobs.value = [of];
      return { strip, end };
    };
    const before = await loaded(job({ state: "running" }));
    expect(before.strip.shownJob.value?.state).toBe("running");
    before.end();
    const after = await loaded(job({ state: "stopped" }));
    expect(after.strip.shownJob.value?.state).toBe("stopped");
    after.strip.dismiss(job({ state: "stopped" }));
    expect(after.strip.shownJob.value).toBeNull();
    after.end();
    const again = await loaded(job({ state: "stopped" }));
    expect(again.strip.shownJob.value).toBeNull();
    again.end();
  });
});

describe("the remaining time", () => {
  afterEach(() => {
    jobs.jobs.value = [];
    vi.useRealTimers();
  });

  it("counts down between two estimates while the job runs", () => {
    vi.useFakeTimers();
    const stop = jobs.follow();
    const report = (more: Partial<Job>) => {
      jobs.jobs.value = [job({ seconds_left: 10, ...more })];
    };
    const left = () => jobs.jobs.value.map(jobs.secondsLeft)[0];
    report({});
    vi.advanceTimersByTime(3000);
    expect(left()).toBe(7);
    // Other news of the job are no new estimate.
    report({ drawn_mm: 5 });
    expect(left()).toBe(7);
    report({ seconds_left: 9 });
    expect(left()).toBe(9);
    report({ seconds_left: 9, state: "paused" });
    vi.advanceTimersByTime(3000);
    expect(left()).toBe(9);
    report({ seconds_left: 1 });
    vi.advanceTimersByTime(3000);
    expect(left()).toBe(0);
    report({ seconds_left: null });
    expect(left()).toBe(null);
    stop();
  });
});
