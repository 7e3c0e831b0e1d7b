// Tests of the routes #/draw and #/engrave: first the preview of the sheet, then the paper with the
// lines that the arm has drawn.
import assert from "node:assert/strict";
import { join } from "node:path";
import { near, waitForState } from "./bench.mjs";

const RECT =
  '<svg xmlns="http://www.w3.org/2000/svg" width="30mm" height="15mm" viewBox="0 0 30 15"><path d="M0 0H30V15H0Z" fill="none" stroke="#b00020"/></svg>';
const TWO =
  '<svg xmlns="http://www.w3.org/2000/svg" width="50mm" height="10mm" viewBox="0 0 50 10"><path d="M0 0H20V10H0Z" fill="none" stroke="#b00020"/><path d="M30 0H50V10H30Z" fill="none" stroke="#0030b0"/></svg>';
/** World with a table below a tool that draws or burns on it. */
const world = (tool) =>
  `title = "${tool}"\narm = { homed = true }\ntool = { kind = "${tool}" }\ntable = { height = -60, x = [60, 340], y = [-200, 200] }\n`;
const file = (name, text) => ({ name, mimeType: "application/octet-stream", buffer: Buffer.from(text) });

export function drawing(test, bench) {
  const { closePage } = bench;
  const shown = (page) => page.locator("[data-testid=draw-preview][data-shown=true]").waitFor();
  const value = async (page, name) => Number(await page.getByTestId(`draw-place-${name}`).inputValue());
  const type = async (page, name, to) => {
    await page.getByTestId(`draw-place-${name}`).fill(String(to));
    await page.getByTestId(`draw-place-${name}`).press("Enter");
  };
  const opened = async (route, tool, options) => {
    const page = await bench.browser.inControl(bench.url(), options);
    await page.goto(`${bench.url()}#/world`);
    await waitForState(page, "route", "world");
    await page.getByTestId("world-scenario-open").setInputFiles(file(`${tool}.toml`, world(tool)));
    await page.getByText("The arm restarted in the new world").waitFor();
    await page.goto(`${bench.url()}#/move`);
    // The page's own station homes its arm in a new world.
    if ((await page.evaluate(() => document.body.dataset.backend)) === "station") {
      await waitForState(page, "alarm", "true");
      await page.getByTestId("clear-alarms").click();
    }
    await waitForState(page, "alarm", "false");
    await page.goto(`${bench.url()}#/${route}`);
    await waitForState(page, "route", route);
    return page;
  };
  const give = async (page, name, text) => {
    const there = (await bench.station.call("program.list")).programs.some((program) => program.name === name);
    await page.getByTestId("draw-open").setInputFiles(file(name, text));
    if (there) await page.getByTestId("confirm-yes").click();
    await shown(page);
  };
  const drag = async (page, testId, dx, dy, steps = 8) => {
    const { x, y, width, height } = await page.getByTestId(testId).boundingBox();
    await page.mouse.move(x + width / 2, y + height / 2);
    await page.mouse.down();
    await page.mouse.move(x + width / 2 + dx, y + height / 2 + dy, { steps });
    await page.mouse.up();
  };
  /** Corners of the lines drawn on the paper since the last call. */
  const marks = async (burnt = false) =>
    (await bench.station.call("world.look")).strokes
      .filter((stroke) => stroke.burnt === burnt)
      .flatMap(({ points }) => points);
  const boundsOf = (points) =>
    [0, 1].map((axis) => [
      Math.min(...points.map((point) => point[axis])),
      Math.max(...points.map((point) => point[axis])),
    ]);
  /**
   * Runs a job to its end. At a multiple of the arm's speed the page may never show it as running.
   */
  const runs = async (page, press = () => page.getByTestId("draw-start").click()) => {
    const last = async () => (await bench.station.call("job.list")).jobs.at(-1);
    const before = (await last())?.job;
    await press();
    const isOver = ({ job, state } = {}) => job !== before && state === "done";
    for (let looks = 0; looks < 450 && !isOver(await last()); looks++) await page.waitForTimeout(200);
    assert.ok(isOver(await last()), JSON.stringify(await last()));
    await waitForState(page, "job", "done");
  };

  test("the sheet: a dragged, scaled and turned object is drawn where it lies", async () => {
    const page = await opened("draw", "pen");
    await give(page, "rectangle.svg", RECT);
    const before = { x: await value(page, "x"), y: await value(page, "y"), width: await value(page, "width") };
    assert.ok(near(before.width, 30, 0.05), `${before.width}`);
    await drag(page, "draw-hold", 40, -60);
    await shown(page);
    const moved = { x: await value(page, "x"), y: await value(page, "y") };
    // For a reader in front of the arm, +y is to the right, and up is towards the arm.
    assert.ok(moved.x < before.x - 2 && moved.y > before.y + 2, JSON.stringify([before, moved]));
    assert.ok(near((before.x - moved.x) / (moved.y - before.y), 60 / 40, 0.1), "as the hand went");
    await drag(page, "draw-corner-2", 30, 15);
    await shown(page);
    assert.ok((await value(page, "width")) > 33);
    await drag(page, "draw-turn", -70, 60);
    await shown(page);
    const turn = await value(page, "rotate");
    assert.ok(turn > 40, `${turn}`);
    const wanted = { x: await value(page, "x"), y: await value(page, "y"), width: await value(page, "width") };
    assert.match(await page.getByTestId("draw-time").textContent(), /^\d+:\d\d$/);
    await runs(page);
    const [[left, right], [bottom, top]] = boundsOf(await marks());
    const half = ([cos, sin] = [Math.cos((turn * Math.PI) / 180), Math.sin((turn * Math.PI) / 180)].map(Math.abs)) => [
      (wanted.width * sin + (wanted.width / 2) * cos) / 2,
      (wanted.width * cos + (wanted.width / 2) * sin) / 2,
    ];
    const [dx, dy] = half();
    for (const [is, should] of [
      [left, wanted.x - dx],
      [right, wanted.x + dx],
      [bottom, wanted.y - dy],
      [top, wanted.y + dy],
    ])
      assert.ok(
        near(is, should, 0.5),
        `${[left, right, bottom, top]} of ${JSON.stringify({ ...wanted, turn, dx, dy })}`,
      );
    await closePage(page);
  });

  test("the sheet: a text is written with the keyboard alone", async () => {
    const page = await opened("draw", "pen");
    const tabTo = async (testId) => {
      for (let press = 0; press < 90; press++) {
        if ((await page.evaluate(() => document.activeElement?.dataset?.testid)) === testId) return;
        await page.keyboard.press("Tab");
      }
      throw new Error(`${testId} is not reached`);
    };
    await tabTo("draw-text");
    await page.keyboard.type("Hi");
    await shown(page);
    await tabTo("draw-preview");
    const before = { x: await value(page, "x"), y: await value(page, "y"), width: await value(page, "width") };
    await page.keyboard.press("Shift+ArrowUp");
    await page.keyboard.press("ArrowRight");
    await page.keyboard.press("ArrowRight");
    await page.keyboard.press("+");
    await page.keyboard.press("[");
    await shown(page);
    assert.ok(near(await value(page, "x"), before.x - 10, 0.11) && near(await value(page, "y"), before.y + 2, 0.11));
    assert.ok(near(await value(page, "width"), before.width * 1.05, 0.11));
    assert.equal(await value(page, "rotate"), 15);
    await tabTo("draw-place-rotate");
    await page.keyboard.type("0");
    await page.keyboard.press("Enter");
    await shown(page);
    await tabTo("draw-start");
    await runs(page, () => page.keyboard.press("Enter"));
    const [[left, right], [bottom, top]] = boundsOf(await marks());
    assert.ok(
      near((left + right) / 2, before.x - 10, 0.4) && near((bottom + top) / 2, before.y + 2, 0.4),
      `${[left, right, bottom, top]}`,
    );
    assert.ok(near(top - bottom, before.width * 1.05, 0.4), "it is as wide along the arm's y");
    await closePage(page);
  });

  test("the sheet: an object out of reach is red, is not drawn, and fits after one press", async () => {
    const page = await opened("draw", "pen");
    await give(page, "rectangle.svg", RECT);
    assert.equal(await page.locator(".plane .unreachable").count(), 0);
    await type(page, "x", 400);
    await shown(page);
    await page.locator(".plane .unreachable").waitFor({ state: "attached" });
    await page.getByTestId("run-complaint-1").waitFor();
    const jobs = (await bench.station.call("job.list")).jobs.length;
    await page.getByTestId("draw-start").click();
    await page.getByTestId("run-complaint-1").waitFor();
    assert.equal((await bench.station.call("job.list")).jobs.length, jobs);
    await page.getByTestId("draw-fit").click();
    await shown(page);
    await page.getByText("The arm can do it").waitFor();
    assert.equal(await page.locator(".plane .unreachable").count(), 0);
    await closePage(page);
  });

  test("the sheet: parts have their colours, and selected parts are drawn alone", async () => {
    const page = await opened("draw", "pen");
    await give(page, "two colours.svg", TWO);
    await page.waitForFunction(() => document.querySelector("[data-testid=parts-by]")?.value === "color", null, {
      timeout: 15_000,
    });
    await page.getByTestId("part-2").waitFor();
    assert.ok(await page.getByRole("radio", { name: "One pen for all" }).isChecked());
    await shown(page);
    const colors = () =>
      page.locator(".plane .drawn").evaluateAll((paths) => paths.map((path) => path.getAttribute("stroke")).sort());
    assert.deepEqual(await colors(), ["#0030b0", "#b00020"]);
    await page.getByTestId("part-only-2").uncheck();
    await page.waitForFunction(() => document.querySelectorAll(".plane .drawn").length === 1);
    await shown(page);
    assert.deepEqual(await colors(), ["#b00020"]);
    assert.ok(await page.getByTestId("part-2").isVisible(), "what is left out can be chosen again");
    await runs(page);
    const [[left, right], [bottom, top]] = boundsOf(await marks());
    assert.ok(near(top - bottom, 20, 0.5) && near(right - left, 10, 0.5), `${[left, right, bottom, top]}`);
    await closePage(page);
  });

  test("the sheet: a name fills it, the next object has its own room, and a new sheet is blank", async () => {
    const page = await opened("draw", "pen");
    await page.getByRole("textbox", { name: "Text" }).fill("Mia");
    await shown(page);
    assert.ok((await value(page, "width")) > 180, `${await value(page, "width")} mm of a sheet of 400`);
    assert.equal(await value(page, "rotate"), 0);
    await type(page, "width", 60);
    await type(page, "x", 200);
    await type(page, "y", -90);
    await shown(page);
    await runs(page);
    const [, [from, to]] = boundsOf(await marks());
    assert.ok(near((from + to) / 2, -90, 0.5) && near(to - from, 60, 0.5), `${from} to ${to}`);
    await page.getByRole("button", { name: "Star", exact: true }).click();
    await page.waitForFunction(() => document.querySelectorAll(".item-row").length === 2);
    await shown(page);
    const star = { x: await value(page, "x"), y: await value(page, "y"), width: await value(page, "width") };
    assert.ok(star.y - star.width / 2 > to || star.y + star.width / 2 < from, JSON.stringify({ star, from, to }));
    await runs(page);
    const tip = (await marks()).filter(([x, y]) => Math.hypot(x - star.x, y - star.y) < star.width * 0.6);
    const [, [left, right]] = boundsOf(tip);
    assert.ok(near(right - left, star.width, 0.5), `${left} to ${right} of ${star.width} mm`);
    await page.getByRole("button", { name: "New sheet" }).first().click();
    await page.getByText("A new sheet lies there.").waitFor();
    assert.deepEqual((await bench.station.call("world.look")).strokes, []);
    assert.ok(await page.getByRole("button", { name: "New sheet" }).first().isDisabled());
    await closePage(page);
  });

  test("the sheet: objects are drawn together in true size, undone and done again", async () => {
    const page = await opened("draw", "pen");
    const objects = () => page.locator(".item-row").count();
    await page.getByRole("button", { name: "Rectangle" }).click();
    await shown(page);
    await type(page, "x", 220);
    await type(page, "y", -50);
    await type(page, "width", 40);
    await shown(page);
    await page.getByRole("button", { name: "Circle" }).click();
    await page.getByTestId("draw-item-1").waitFor({ state: "attached" });
    await shown(page);
    await type(page, "x", 220);
    await type(page, "y", 60);
    await type(page, "width", 30);
    await shown(page);
    await page.getByRole("radio", { name: "red" }).check({ force: true });
    await shown(page);
    await page.getByTestId("draw-preview").focus();
    await page.keyboard.press("Delete");
    assert.equal(await objects(), 1);
    await page.keyboard.press("Control+z");
    assert.equal(await objects(), 2);
    await page.keyboard.press("Control+y");
    assert.equal(await objects(), 1);
    await page.getByTestId("draw-undo").click();
    await shown(page);
    // Two pens: the job waits for the second one.
    await page.getByRole("radio", { name: "Change the pen between them" }).check({ force: true });
    await shown(page);
    await page.getByTestId("draw-start").click();
    await waitForState(page, "job", "paused", 60_000);
    const first = await marks();
    await page.getByTestId("run-resume").or(page.getByTestId("job-strip-pause")).first().click();
    await waitForState(page, "job", "done", 60_000);
    const all = await marks();
    const side = (points, axis) => boundsOf(points)[axis];
    const [left, right] = [all.filter(([, y]) => y < 0), all.filter(([, y]) => y > 0)];
    assert.ok(first.length > 0 && first.length < all.length, "one pen before the pause, one after it");
    const [[lx0, lx1], [ly0, ly1]] = [side(left, 0), side(left, 1)];
    assert.ok(near(ly1 - ly0, 40, 0.4) && near(lx1 - lx0, 27.2, 0.4), `${[lx0, lx1, ly0, ly1]}`);
    const [[rx0, rx1], [ry0, ry1]] = [side(right, 0), side(right, 1)];
    assert.ok(near(ry1 - ry0, 30, 0.4) && near(rx1 - rx0, 30, 0.4), `${[rx0, rx1, ry0, ry1]}`);
    assert.ok(near((ry0 + ry1) / 2, 60, 0.4) && near((rx0 + rx1) / 2, 220, 0.4));
    await closePage(page);
  });

  test("the sheet: filled shapes that become outlines get a note, and are filled after one press", async () => {
    const page = await opened("draw", "pen");
    await give(page, "filled.svg", RECT.replace('fill="none" stroke="#b00020"', 'fill="#b00020"'));
    await page.getByText("They will be outlines.").waitFor();
    await page.getByRole("button", { name: "Fill them with lines" }).click();
    await page.getByText("They will be outlines.").waitFor({ state: "detached" });
    await shown(page);
    await type(page, "width", 15);
    await shown(page);
    await runs(page);
    const points = await marks();
    const [[left, right], [bottom, top]] = boundsOf(points);
    // Hatch lines end along all edges and not only at the corners.
    assert.ok(points.length > 20 && near(right - left, 7.5, 1) && near(top - bottom, 15, 1), `${points.length} points`);
    await closePage(page);
  });

  test("presets: saved, selected into the fields, and removed", async () => {
    const page = await opened("draw", "pen");
    await give(page, "rectangle.svg", RECT);
    await page.getByTestId("setup-speed").fill("37");
    await page.getByTestId("setup-speed").press("Tab");
    await page.getByTestId("preset-more").locator("summary").click();
    await page.getByTestId("preset-name").fill("suite-pen");
    await page.getByTestId("preset-save").click();
    await page.getByText("suite-pen is saved.").waitFor();
    assert.deepEqual((await bench.station.call("preset.show", { name: "suite-pen" })).options.speed, 37);
    await page.getByTestId("setup-speed").fill("12");
    await page.getByTestId("setup-speed").press("Tab");
    await page.getByTestId("preset-save").click();
    await page.getByTestId("confirm-no").click();
    assert.deepEqual((await bench.station.call("preset.show", { name: "suite-pen" })).options.speed, 37);
    await page.getByTestId("setup-speed").fill("11");
    await page.getByTestId("setup-speed").press("Tab");
    await page.getByTestId("preset-tile-marker").click();
    await page.getByTestId("preset-note").getByText("not tried").waitFor();
    assert.ok(await page.getByTestId("preset-remove").isDisabled(), "one that comes with the program stays");
    await page.getByTestId("preset-tile-suite-pen").click();
    await page.waitForFunction(() => document.querySelector("[data-testid=setup-speed]").value === "37");
    const [file] = await Promise.all([page.waitForEvent("download"), page.getByTestId("preset-file").click()]);
    assert.equal(file.suggestedFilename(), "suite-pen.toml");
    await page.getByTestId("preset-remove").click();
    await page.getByTestId("preset-tile-suite-pen").waitFor({ state: "detached" });
    await closePage(page);
  });

  test("engraving: nothing burns before the laser is armed, and every end disarms it", async () => {
    const page = await opened("engrave", "laser");
    const armed = () => page.getByTestId("laser-arm").getAttribute("aria-checked");
    await give(page, "rectangle.svg", RECT);
    assert.ok(await page.getByTestId("draw-start").isDisabled());
    assert.match(
      await page.locator(`#${await page.getByTestId("draw-start").getAttribute("aria-describedby")}`).textContent(),
      /arm the laser/i,
    );
    // Frames the drawing without the laser.
    await runs(page, () => page.getByTestId("laser-frame").click());
    assert.deepEqual(await marks(true), []);
    for (const leave of ["hidden", "route"]) {
      await page.getByTestId("laser-arm").click();
      assert.equal(await armed(), "true");
      assert.ok(await page.getByTestId("draw-start").isEnabled());
      await page.evaluate((leave) => {
        if (leave === "route") return void (location.hash = "#/move");
        Object.defineProperty(document, "hidden", { configurable: true, get: () => true });
        document.dispatchEvent(new Event("visibilitychange"));
        delete document.hidden;
      }, leave);
      if (leave === "route") {
        await waitForState(page, "route", "move");
        await page.goto(`${bench.url()}#/engrave`);
        await waitForState(page, "route", "engrave");
        await shown(page);
      }
      assert.equal(await armed(), "false", leave);
      assert.ok(await page.getByTestId("draw-start").isDisabled(), leave);
    }
    await page.getByTestId("laser-arm").click();
    await runs(page);
    await page.locator("[data-testid=laser-arm][aria-checked=false]").waitFor({ timeout: 3000 });
    assert.ok(await page.getByTestId("draw-start").isDisabled());
    const [, [left, right]] = boundsOf(await marks(true));
    assert.ok(near(right - left, 30, 0.5), `${left} to ${right}`);
    assert.equal((await bench.station.pose()).tool.laser, false);
    await closePage(page);
  });

  test("engraving: a test grid is laid on the sheet and burnt as one", async () => {
    const page = await opened("engrave", "laser");
    await page.getByTestId("testgrid-power").fill("20:80:2");
    await page.getByTestId("testgrid-speed").fill("60:80:2");
    await page.getByTestId("testgrid-cell").fill("9");
    await page.getByTestId("laser-testgrid").click();
    await shown(page);
    const drawn = await page.locator(".plane .drawn").count();
    assert.ok(drawn > 0);
    await page.getByTestId("laser-arm").click();
    await page.getByTestId("draw-start").click();
    await waitForState(page, "job", "running");
    for (let looks = 0; looks < 200 && (await marks(true)).length === 0; looks++) await page.waitForTimeout(100);
    await page.getByTestId("stop").click();
    await waitForState(page, "job", "stopped");
    await bench.station.waitForRest();
    const burnt = JSON.stringify(await marks(true));
    assert.ok(burnt.length > 2, "nothing was burnt");
    await page.waitForTimeout(500);
    assert.equal(JSON.stringify(await marks(true)), burnt, "it burns on");
    assert.equal(await page.getByTestId("laser-arm").getAttribute("aria-checked"), "false");
    await closePage(page);
  });

  if (bench.outlives !== true) return;
  test("the pictures of the guide: drawing and engraving", async () => {
    const sample = (name) => join(import.meta.dirname, "../../crates/magician-program/samples", name);
    for (const [route, tool, name] of [
      ["draw", "pen", "rabbit.svg"],
      ["engrave", "laser", "house.svg"],
    ]) {
      const page = await opened(route, tool, { viewport: { width: 1280, height: 800 } });
      await page.getByTestId("draw-open").setInputFiles(sample(name));
      if ((await page.getByTestId("confirm-yes").count()) > 0) await page.getByTestId("confirm-yes").click();
      await page.getByText("The arm can do it").waitFor();
      await shown(page);
      await type(page, "rotate", route === "draw" ? 12 : -8);
      await shown(page);
      if (route === "engrave") await page.getByTestId("laser-arm").click();
      await page.waitForTimeout(300);
      await page.screenshot({ path: join(bench.shots, `${route}.png`) });
      await closePage(page);
    }
  });

  test("engraving: closing the page during a job switches the laser off", async () => {
    const page = await opened("engrave", "laser");
    page.on("dialog", (dialog) => void dialog.accept());
    await give(page, "rectangle.svg", RECT);
    await type(page, "width", 60);
    await shown(page);
    await page.getByTestId("laser-arm").click();
    await page.getByTestId("draw-start").click();
    await waitForState(page, "job", "running");
    for (let looks = 0; looks < 300 && (await marks(true)).length === 0; looks++) await page.waitForTimeout(50);
    assert.ok((await marks(true)).length > 0, "nothing burns yet");
    const began = Date.now();
    await page.close({ runBeforeUnload: false });
    // Burning is sent in pieces of at most one second. After a stop the laser is dark within 1.5 s.
    await new Promise((done) => setTimeout(done, Math.max(0, 1500 - (Date.now() - began))));
    const then = JSON.stringify(await marks(true));
    const job = (await bench.station.call("job.list")).jobs.at(-1);
    console.log(`      ${((Date.now() - began) / 1000).toFixed(1)} s after it was closed: the job is ${job.state}`);
    assert.notEqual(job.state, "running");
    await new Promise((done) => setTimeout(done, 2000));
    assert.equal(JSON.stringify(await marks(true)), then, "it burns on");
    assert.equal((await bench.station.pose()).tool.laser, false);
    await bench.station.until("is free", (state) => state.holder === null, 8000);
    await page.context().close();
  });
}
