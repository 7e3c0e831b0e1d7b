// Tests of the route #/teach: points captured, edited, undone, played, saved and opened, checked at
// the station.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { near, waitForState } from "./bench.mjs";

export function teaching(test, { browser, station, closePage, shots }) {
  const opened = async (options) => {
    const page = await browser.inControl(station.url, options);
    page.on("dialog", (dialog) => dialog.accept());
    if ((await page.evaluate(() => document.body.dataset.alarm)) === "true")
      await page.getByTestId("clear-alarms").click();
    await waitForState(page, "alarm", "false");
    await page.goto(`${station.url}#/teach`);
    await waitForState(page, "route", "teach");
    return page;
  };
  const rows = (page) => page.locator("[data-testid^=teach-row-]").count();
  const add = async (page, to) => {
    const before = await rows(page);
    await station.waitForRest();
    const there = await moved(page, to);
    await page.getByTestId("teach-add").click();
    await page.getByTestId(`teach-row-${before + 1}`).waitFor();
    return there;
  };
  /** Moves by steps of the jog pad beside the table. */
  const moved = async (page, [button, size]) => {
    await page.getByTestId("jog-mode-step").check({ force: true });
    await page.getByTestId("jog-step-size").selectOption(String(size));
    const before = await station.waitForRest();
    await page.getByTestId(`jog-${button}`).click();
    const [axis, sign] = button.split("-");
    const to = before[axis] + (sign === "plus" ? size : -size);
    return station.until("a step", (state) => !state.moving && near(state[axis], to));
  };
  const cell = (page, axis, n) => page.getByLabel(`${axis} of point ${n}`, { exact: true });
  const kept = async (page) => {
    // The page stores a change 0.25 s after the last one.
    await page.waitForTimeout(600);
    return page.evaluate(() => JSON.parse(localStorage.getItem("magician.teach")).taught.rows);
  };

  test("points are captured, edited, moved, deleted, and all of it is undone", async () => {
    const page = await opened();
    const one = await add(page, ["z-plus", 10]);
    const two = await add(page, ["y-plus", 10]);
    assert.ok(
      near(Number(await cell(page, "x", 1).inputValue()), one.x) &&
        near(Number(await cell(page, "y", 2).inputValue()), two.y),
    );
    await page.getByRole("combobox", { name: "Motion to point 2" }).selectOption("line");
    await page.getByRole("combobox", { name: "Tool at point 2" }).selectOption("suction");
    assert.equal((await kept(page))[1].wait, 0.5, "suction needs a moment");
    await page.getByLabel("Wait at point 2, seconds").fill("0,7");
    await page.getByLabel("Wait at point 2, seconds").press("Tab");
    await cell(page, "z", 1).fill("nonsense");
    await cell(page, "z", 1).press("Tab");
    assert.ok(near(Number(await cell(page, "z", 1).inputValue()), one.z));
    const [, second] = await kept(page);
    assert.deepEqual([second.motion.by, second.suction, second.wait], ["line", true, 0.7]);
    // Moves a row by keyboard, and back by mouse.
    await page.getByTestId("teach-pick-2").focus();
    await page.keyboard.press("Alt+ArrowUp");
    assert.equal((await kept(page))[0].name, "P2");
    assert.equal(await page.evaluate(() => document.activeElement.dataset.testid), "teach-pick-1");
    const handle = await page.locator("[data-testid=teach-row-1] .row-grip").boundingBox();
    const under = await page.locator("[data-testid=teach-row-2] .row-grip").boundingBox();
    await page.mouse.move(handle.x + 10, handle.y + 10);
    await page.mouse.down();
    await page.mouse.move(under.x + 10, under.y + 12, { steps: 4 });
    await page.mouse.up();
    assert.equal((await kept(page))[0].name, "P1");
    await page.getByTestId("teach-pick-1").check();
    await page.getByTestId("teach-delete").click();
    assert.deepEqual(
      (await kept(page)).map(({ name }) => name),
      ["P2"],
    );
    // Undoes eight changes: delete, drag, key, wait, tool, path, two points.
    for (let undone = 0; undone < 8; undone++) await page.getByTestId("teach-undo").click();
    assert.equal(await rows(page), 0);
    assert.ok(await page.getByTestId("teach-undo").isDisabled());
    await page.getByTestId("teach-title").blur();
    for (let redone = 0; redone < 8; redone++) await page.getByTestId("teach-redo").click();
    assert.deepEqual(
      (await kept(page)).map(({ name }) => name),
      ["P2"],
    );
    await closePage(page);
  });

  test("points are played, from a row on, and one alone; the current row is marked", async () => {
    const page = await opened();
    // With a pen the arm also ends at the last point.
    await page.getByTestId("tool-select").selectOption("pen");
    await station.until("has a pen", (state) => state.tool.name === "pen");
    const one = await add(page, ["z-plus", 10]);
    await add(page, ["y-plus", 50]);
    await page.getByLabel("Wait at point 2, seconds").fill("3");
    await page.getByLabel("Wait at point 2, seconds").press("Tab");
    const three = await add(page, ["z-minus", 10]);
    await page.getByTestId("teach-play").click();
    await waitForState(page, "job", "running");
    await page.locator("[data-testid=teach-row-2][aria-current=step]").waitFor();
    await page.setViewportSize({ width: 1280, height: 1120 });
    await page.evaluate(() => scrollTo(0, 0));
    await page.screenshot({ path: join(shots, "teach.png") });
    await waitForState(page, "job", "done", 30_000);
    const end = await station.waitForRest();
    assert.ok(near(end.y, three.y) && near(end.z, three.z), JSON.stringify([three, end]));
    await page.getByTestId("teach-row-1").click();
    await page.getByTestId("teach-step").click();
    await station.until(
      "is at the first point",
      (state) => !state.moving && near(state.y, one.y) && near(state.z, one.z),
      20_000,
    );
    await waitForState(page, "job", "done", 30_000);
    await page.getByTestId("teach-row-3").click();
    await page.getByTestId("teach-from").click();
    await station.until(
      "is at the last point",
      (state) => !state.moving && near(state.y, three.y) && near(state.z, three.z),
      20_000,
    );
    await waitForState(page, "job", "done", 30_000);
    assert.equal((await station.call("job.list")).jobs.at(-1).first_step, 4);
    await closePage(page);
  });

  test("the unlock key of the arm adds points", async () => {
    // Pushing the virtual arm by hand takes a session of the page's own, which has the lease.
    const init = () => {
      window.Worker = class extends Worker {
        constructor(...given) {
          super(...given);
          window.hand = (method, params) =>
            this.postMessage({ kind: "send", message: { jsonrpc: "2.0", id: 1e9, method, params } });
        }
      };
    };
    const page = await opened({ init });
    const enabled = async () => (await station.call("arm.get", { command: "HHTTrigOutputEnabled" })).is_enabled;
    const guides = (is) => page.locator(`[data-testid=teach-guide][aria-checked=${is}]`).waitFor();
    const led = async (joints) => {
      for (const [method, params] of [
        ["world.unlock", { held: true }],
        ["world.guide", { joints }],
        ["world.unlock", { held: false }],
      ]) {
        await page.evaluate(([method, params]) => window.hand(method, params), [method, params]);
      }
      await station.until("was led", (state) => near(state.j2, joints[1]));
    };
    await page.getByText("More: unlock key").click();
    await page.getByRole("switch", { name: "unlock key" }).click();
    await guides(true);
    await led([10, 40, 40, 0]);
    await page.getByTestId("teach-row-1").waitFor();
    await led([-10, 30, 40, 0]);
    await page.getByTestId("teach-row-2").waitFor();
    const { y } = await station.waitForRest();
    assert.ok(near(Number(await cell(page, "y", 2).inputValue()), y), `${y}`);
    await page.getByTestId("lease-release").click();
    await waitForState(page, "lease", "free");
    await guides(false);
    await page.getByTestId("lease-take").click();
    await waitForState(page, "lease", "mine");
    await page.getByRole("switch", { name: "unlock key" }).click();
    await guides(true);
    assert.equal(await enabled(), 1);
    await page.goto(`${station.url}#/move`);
    await waitForState(page, "route", "move");
    for (let tries = 0; (await enabled()) !== 0; tries++) {
      assert.ok(tries < 30, "it is restored");
      await new Promise((done) => setTimeout(done, 100));
    }
    // After being pushed by hand the arm counts as unhomed for real programs, so it is homed for
    // the following tests.
    await page.getByTestId("home").click();
    await waitForState(page, "moving", "true");
    await waitForState(page, "moving", "false", 40_000);
    await closePage(page);
  });

  test("unsaved points survive a reload, are saved, converted and opened again", async () => {
    const page = await opened({ acceptDownloads: true });
    await add(page, ["z-plus", 10]);
    await add(page, ["y-minus", 10]);
    await page.getByRole("combobox", { name: "Tool at point 2" }).selectOption("suction");
    await page.getByText("More: unlock key").click();
    await page.getByTestId("teach-output-high").click();
    await page.getByTestId("teach-row-3").waitFor();
    const taught = await kept(page);
    await page.reload();
    await waitForState(page, "lease", "mine");
    await page.getByTestId("teach-row-3").waitFor();
    assert.deepEqual(await kept(page), taught);
    await page.getByTestId("teach-title").fill("lesson");
    await page.getByTestId("teach-title").press("Tab");
    const saved = async () => {
      const [download] = await Promise.all([page.waitForEvent("download"), page.getByTestId("teach-save").click()]);
      await page.getByText("Saved as").waitFor();
      return [download.suggestedFilename(), await download.path()];
    };
    const [name, path] = await saved();
    assert.equal(name, "lesson.plan.json");
    const plan = JSON.parse(readFileSync(path, "utf8"));
    assert.deepEqual(
      plan.steps.map((step) => Object.keys(step)[0]),
      ["move", "move", "suction", "wait", "command"],
    );
    assert.equal((await station.call("job.check", { program: name })).ok, true);
    await page.getByTestId("teach-save-format").selectOption("playback");
    await page.getByTestId("teach-save").click();
    await page.getByText("a playback file cannot store").waitFor();
    await page.getByTestId("teach-row-3").click();
    await page.getByTestId("teach-delete").click();
    const [playback, playbackPath] = await saved();
    assert.equal(playback, "lesson.playback");
    await page.getByTestId("teach-open").setInputFiles({
      name: "again.playback",
      mimeType: "application/octet-stream",
      buffer: readFileSync(playbackPath),
    });
    await page.waitForFunction(() => document.querySelector("[data-testid=teach-title]").value !== "lesson");
    const again = await kept(page);
    assert.ok(again.length >= 2 && near(again[0].motion.move[1], taught[0].motion.move[1], 0.1), JSON.stringify(again));
    await page.getByTestId("teach-undo").click();
    assert.deepEqual(await kept(page), taught.slice(0, 2));
    await closePage(page);
  });

  test("a cube is put on another by names alone, and an empty pick is reported", async () => {
    const page = await opened();
    await page.goto(`${station.url}#/world`);
    await waitForState(page, "route", "world");
    await page.getByTestId("world-scenario").selectOption({ label: "Three cubes" });
    await page.getByText("Objects: 3").waitFor();
    let presses = 0;
    const press = (name) => {
      presses++;
      return page.getByRole("button", { name, exact: true }).click();
    };
    await page.goto(`${station.url}#/teach`);
    await waitForState(page, "route", "teach");
    const picked = page.getByRole("button", { name: "Put on the blue cube", exact: true });
    await picked.waitFor();
    assert.ok(await picked.isDisabled(), "nothing is held");
    await press("Pick up the red cube");
    await press("Put on the blue cube");
    await press("Play all");
    assert.equal(presses, 3);
    await waitForState(page, "job", "running");
    await waitForState(page, "job", "done", 60_000);
    const objects = Object.fromEntries((await station.call("world.look")).objects.map((one) => [one.name, one]));
    const [red, blue] = [objects["red cube"], objects["blue cube"]];
    assert.ok(near(red.at[0], blue.at[0]) && near(red.at[1], blue.at[1]), JSON.stringify(red));
    assert.ok(near(red.at[2], blue.at[2] + blue.size[2]), "it stands on it");
    // The saved plan contains the wait.
    assert.deepEqual(
      (await kept(page)).map(({ wait }) => wait),
      [null, 0.5, null, null, 0.5, null],
    );
    assert.equal((await station.call("job.list")).jobs.at(-1).notes, null, "it was picked");
    // The object is no longer at its old position, and the job reports that.
    await press("Undo");
    await press("Play all");
    await waitForState(page, "job", "running");
    await waitForState(page, "job", "done", 60_000);
    await page.getByTestId("job-note-nothing-picked").waitFor();
    const { notes } = (await station.call("job.list")).jobs.at(-1);
    assert.deepEqual(notes.map(({ code }) => code).toSorted(), ["left-on", "nothing-picked"]);
    await page.getByRole("button", { name: "Switch the suction cup off" }).click();
    await station.until("is off", ({ tool }) => tool.suction === false);
    await page.getByTestId("job-strip-close").click();
    // By hand: above the object, and onto it.
    await press("Go onto the green cube");
    const green = objects["green cube"];
    await station.until(
      "is on it",
      (state) => near(state.x, green.at[0]) && near(state.z, green.at[2] + green.size[2]) && !state.moving,
    );
    await closePage(page);
  });
}
