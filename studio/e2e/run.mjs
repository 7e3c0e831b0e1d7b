// Tests of the route #/run: programs opened, checked, run, paused and resumed, checked at the
// station.
import assert from "node:assert/strict";
import { join } from "node:path";
import { waitForState } from "./bench.mjs";

const SQUARE =
  '<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="40mm" viewBox="0 0 40 40"><path d="M0 0H40V40H0Z" fill="none" stroke="#000"/></svg>';
/** Program whose third line is out of reach. */
const FAR = "G21\nG90\nG0 X600 Y0 Z-50\nG1 X610 F1200\n";
const file = (name, text) => ({ name, mimeType: "application/octet-stream", buffer: Buffer.from(text) });

export function running(test, { browser, station, closePage, shots }) {
  const job = async () => (await station.call("job.list")).jobs.at(-1);
  const until = async (what, is) => {
    for (const ends = Date.now() + 15_000; ; await new Promise((done) => setTimeout(done, 100))) {
      const now = await job();
      if (now !== undefined && is(now)) return now;
      if (Date.now() > ends) throw new Error(`the job: ${what}: ${JSON.stringify(now)}`);
    }
  };
  const opened = async (options) => {
    const page = await browser.inControl(station.url, options);
    if ((await page.evaluate(() => document.body.dataset.alarm)) === "true")
      await page.getByTestId("clear-alarms").click();
    await waitForState(page, "alarm", "false");
    await page.goto(`${station.url}#/run`);
    await waitForState(page, "route", "run");
    return page;
  };
  const give = async (page, name, text) => {
    const replaced = (await station.call("program.list")).programs.some((program) => program.name === name);
    await page.getByTestId("program-open").setInputFiles(file(name, text));
    if (replaced) await page.getByTestId("confirm-yes").click();
    await page.locator(`[data-testid="program-${name}"][aria-selected=true]`).waitFor();
  };
  const shown = (page) => page.locator("[data-testid=run-preview][data-shown=true]").waitFor();

  test("Start works during another check of the program", async () => {
    const page = await opened();
    await give(page, "at once.svg", SQUARE);
    const before = (await station.call("job.list")).jobs.length;
    await page.evaluate(() =>
      ["run-start", "run-check"].forEach((name) => document.querySelector(`[data-testid=${name}]`).click()),
    );
    await waitForState(page, "job", "running");
    await page.getByTestId("stop").click();
    await waitForState(page, "job", "stopped");
    assert.equal((await station.call("job.list")).jobs.length, before + 1);
    await closePage(page);
  });

  test("a drawing is opened, previewed, drawn, paused and resumed", async () => {
    const page = await opened();
    await give(page, "square.svg", SQUARE);
    assert.ok(
      (await station.call("program.list")).programs.some(
        ({ name, format }) => name === "square.svg" && format === "svg",
      ),
    );
    await page.getByTestId("setup-at").fill("220 10");
    await page.getByTestId("setup-at").press("Tab");
    await shown(page);
    await page.getByText("The arm can do it").waitFor();
    const before = await station.waitForRest();
    await page.getByTestId("run-check").click();
    await page.getByText("The arm can do it").waitFor();
    assert.equal((await station.pose()).x, before.x, "a check moves nothing");
    await page.getByTestId("run-start").click();
    await waitForState(page, "job", "running");
    const { title } = await until("runs", ({ step }) => step > 2);
    assert.equal(title, "square");
    assert.ok(Number(await page.getByTestId("run-progress").getAttribute("aria-valuenow")) >= 0);
    assert.ok(await page.getByTestId("run-start").isDisabled());
    await page
      .getByTestId("run-left")
      .filter({ hasText: /\d:\d\d/ })
      .waitFor();
    await page.screenshot({ path: join(shots, "run.png") });
    await page.getByTestId("run-pause").click();
    await waitForState(page, "job", "paused");
    const stood = await station.waitForRest();
    assert.ok(stood.z > -60 + 1, "the pen is up");
    // During a pause the arm can be moved.
    await station.waitForRest();
    await page.getByTestId("run-resume").click();
    await waitForState(page, "job", "running");
    await waitForState(page, "job", "done", 60_000);
    assert.equal(await page.getByTestId("run-progress").getAttribute("aria-valuenow"), "100");
    const { drawing } = await station.call("world.look");
    assert.match(drawing, /<(path|polyline)/);
    await closePage(page);
  });

  test("a drawing that would leave no marks is reported before it starts", async () => {
    const page = await opened();
    const inWorld = async (name) => {
      await page.goto(`${station.url}#/world`);
      await page.getByTestId("world-scenario").selectOption(name);
      await page.getByText("The arm restarted in the new world").waitFor();
    };
    await inWorld("cubes");
    await page.getByTestId("world-paper-none").getByText("takes a pen above a table").waitFor();
    await page.goto(`${station.url}#/run`);
    await give(page, "square.svg", SQUARE);
    await page.getByTestId("run-bare").getByText("has no pen").waitFor();
    await page.getByTestId("setup-tool").selectOption("laser");
    await page.getByTestId("run-bare").getByText("has no laser").waitFor();
    await inWorld("drawing");
    await page.goto(`${station.url}#/run`);
    await page.getByTestId("run-bare").getByText("has no laser").waitFor();
    await page.getByTestId("setup-tool").selectOption("pen");
    await page.getByText("The arm can do it").waitFor();
    await page.getByTestId("run-bare").waitFor({ state: "detached" });
    await page.getByTestId("alarm-banner").locator("li").first().waitFor();
    await page.goto(`${station.url}#/move`);
    await page.getByTestId("clear-alarms").click();
    await waitForState(page, "alarm", "false");
    await closePage(page);
  });

  test("an impossible step is refused at its line, and nothing moves", async () => {
    const page = await opened();
    await give(page, "far.gcode", FAR);
    const before = await station.waitForRest();
    await page.getByTestId("run-complaint-1").waitFor();
    const text = await page.getByTestId("run-complaint-1").textContent();
    assert.match(text, /Line 3/);
    await page.getByTestId("run-complaint-1").click();
    const line = page.locator("[data-testid=run-lines] .at");
    await line.waitFor();
    assert.match(await line.textContent(), /X600/);
    const jobs = (await station.call("job.list")).jobs.length;
    await page.getByTestId("run-start").click();
    await page.getByTestId("run-complaint-1").waitFor();
    assert.equal((await station.call("job.list")).jobs.length, jobs, "no job began");
    assert.equal((await station.waitForRest()).x, before.x);
    await page.getByRole("button", { name: "Delete far.gcode" }).click();
    await page.getByTestId("confirm-yes").click();
    await page.getByTestId("program-far.gcode").waitFor({ state: "detached" });
    await closePage(page);
  });

  test("a job is stopped with its pen up, and the page's stop leaves no lines", async () => {
    const page = await opened();
    await give(page, "square.svg", SQUARE);
    await page.getByText("The arm can do it").waitFor();
    for (const button of ["run-stop", "stop"]) {
      await page.getByTestId("run-start").click();
      await until("draws", ({ state, step }) => state === "running" && step > 3);
      await page.getByTestId(button).click();
      await waitForState(page, "job", "stopped");
      const { z } = await station.waitForRest();
      if (button === "run-stop") assert.ok(z > -60 + 1, `the pen is up: ${z}`);
      assert.ok((await job()).step > 0);
    }
    await page.getByTestId("run-resume").waitFor();
    await closePage(page);
  });

  test("another client's job is shown as such, and every client may stop it", async () => {
    const page = await opened();
    await give(page, "square.svg", SQUARE);
    await page.getByText("The arm can do it").waitFor();
    await page.getByTestId("lease-release").click();
    await waitForState(page, "lease", "free");
    const other = await opened({ init: () => localStorage.setItem("magician.name", "Grace") });
    await other.getByTestId("program-square.svg").getByRole("button").first().click();
    await other.getByText("The arm can do it").waitFor();
    await other.getByTestId("run-start").click();
    await waitForState(page, "job", "running");
    await page.getByText("started by Grace").waitFor();
    assert.ok(await page.getByTestId("job-strip-pause").isDisabled());
    await page.getByTestId("run-stop").click();
    await waitForState(other, "job", "stopped");
    await closePage(other);
    await closePage(page);
  });

  test("without WebGL the plan is shown from above", async () => {
    const init = () => {
      HTMLCanvasElement.prototype.getContext = () => null;
    };
    const page = await opened({ init });
    await give(page, "square.svg", SQUARE);
    await shown(page);
    const planned = await page
      .locator(".plan path")
      .evaluateAll((paths) =>
        paths.filter((path) => path.getAttribute("stroke") === "var(--planned)").map((path) => path.getAttribute("d")),
      );
    assert.equal(planned.length, 1);
    assert.ok(planned[0].split("L").length >= 5, planned[0]);
    await page.getByTestId("run-preview").click();
    await page.locator("[data-testid=run-preview][data-shown=false]").waitFor();
    await closePage(page);
  });

  test("a file of a million lines does not block the page", async () => {
    const init = () => {
      window.longest = 0;
      window.read = 0;
      for (const name of ["text", "arrayBuffer"]) {
        const plain = Blob.prototype[name];
        Blob.prototype[name] = function () {
          window.read = Math.max(window.read, this.size);
          return plain.call(this);
        };
      }
      new PerformanceObserver((list) =>
        list.getEntries().forEach(({ duration }) => (window.longest = Math.max(window.longest, duration))),
      ).observe({ entryTypes: ["longtask"] });
    };
    const page = await opened({ init });
    const row = Array.from(
      { length: 1000 },
      (_, nth) => `X${(220 + (nth % 40) / 2).toFixed(1)}Y${(nth % 25) / 2}\n`,
    ).join("");
    const path = join(station.state, "million.gcode");
    const { createWriteStream } = await import("node:fs");
    await new Promise((done) => {
      const to = createWriteStream(path).on("finish", done);
      to.write("G21\nG90\nG1 F3000 Z-50\n");
      for (let nth = 0; nth < 1000; nth++) to.write(row);
      to.end();
    });
    await page.evaluate(() => (window.longest = 0));
    await page.getByTestId("program-open").setInputFiles(path);
    await page.locator('[data-testid="program-million.gcode"][aria-selected=true]').waitFor({ timeout: 60_000 });
    const longest = await page.evaluate(() => window.longest);
    console.log(
      `      the longest task while ${((await station.call("program.list")).programs.find(({ name }) => name === "million.gcode").bytes / 1e6).toFixed(0)} MB were opened: ${longest.toFixed(0)} ms`,
    );
    // The duration of a task depends on the machine, but the page itself must not read large files.
    const read = await page.evaluate(() => window.read);
    assert.ok(read <= 1_000_000, `${read} bytes at once`);
    await station.call("program.delete", { name: "million.gcode" });
    await closePage(page);
  });
}
