// Main tasks from beginning to end: engraving a photo, and the first drawing on an arm with an
// unmeasured table.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { near, Station, waitForState } from "./bench.mjs";

/** Height of the arm's paper, mm, which the page does not know. */
const PAPER = -52.5;

/**
 * Portrait as a camera takes it, in greys without edges: drawn by the browser, and saved as a JPEG.
 */
export const photo = (page) =>
  page.evaluate(() => {
    const canvas = Object.assign(document.createElement("canvas"), { width: 240, height: 300 });
    const pen = canvas.getContext("2d");
    const soft = (x, y, size, from, to, stretch = 1) => {
      pen.save();
      pen.translate(x, y);
      pen.scale(1, stretch);
      const shade = pen.createRadialGradient(-size / 3, -size / 3, size / 8, 0, 0, size);
      shade.addColorStop(0, `rgb(${from} ${from} ${from})`);
      shade.addColorStop(1, `rgb(${to} ${to} ${to})`);
      pen.fillStyle = shade;
      pen.beginPath();
      pen.arc(0, 0, size, 0, 2 * Math.PI);
      pen.fill();
      pen.restore();
    };
    const back = pen.createLinearGradient(0, 0, 240, 300);
    back.addColorStop(0, "rgb(250 250 250)");
    back.addColorStop(1, "rgb(150 150 150)");
    pen.fillStyle = back;
    pen.fillRect(0, 0, 240, 300);
    soft(120, 330, 110, 130, 60);
    soft(120, 125, 84, 70, 30, 1.15);
    soft(120, 140, 66, 245, 130, 1.25);
    for (const x of [95, 145]) soft(x, 130, 9, 40, 90, 0.8);
    soft(120, 158, 9, 230, 150, 1.5);
    soft(120, 190, 22, 120, 160, 0.35);
    return canvas.toDataURL("image/jpeg", 0.9).split(",")[1];
  });

/** Waits until the job of this arm has ended. */
async function done(station, within = 240_000) {
  for (const ends = Date.now() + within; Date.now() < ends; ) {
    const job = (await station.call("job.list")).jobs.at(-1);
    if (job?.state === "done") return;
    assert.ok(!["failed", "stopped", "interrupted"].includes(job?.state), JSON.stringify(job));
    await new Promise((over) => setTimeout(over, 250));
  }
  assert.fail("the job does not end");
}

export function walkthroughs(test, { browser, program, shots }) {
  const shot = (page, name, options = {}) => page.screenshot({ path: join(shots, `${name}.png`), ...options });
  const shown = (page) => page.locator("[data-testid=draw-preview][data-shown=true]").waitFor();

  test("a photo is engraved from the page, up to the burnt plate", async () => {
    // The job takes long on a real arm, so this one is ten times as fast.
    const station = new Station(program, ["--port", "sim:10"]);
    await station.start();
    try {
      const page = await browser.inControl(`${station.url}#/engrave`);
      await waitForState(page, "route", "engrave");
      const buffer = Buffer.from(await photo(page), "base64");
      // Settings of an earlier drawing with the pen must not affect the laser.
      await page.getByTestId("draw-open").setInputFiles({ name: "portrait.jpg", mimeType: "image/jpeg", buffer });
      await page.getByText("The arm can do it").waitFor();
      await shown(page);
      assert.equal(await page.getByTestId("setup-image").count(), 0, "what the pen makes of it is not asked");
      await page.getByTestId("draw-place-width").fill("20");
      await page.getByTestId("draw-place-width").press("Enter");
      // The engraving would be invisible on the current paper. The note offers a wooden plate.
      await page.getByTestId("run-scenario").filter({ hasText: "Engraving" }).click();
      await page.getByTestId("run-bare").waitFor({ state: "detached" });
      assert.equal((await station.call("world.look")).title, "Engraving");
      await page.getByText("The arm can do it").waitFor();
      await shown(page);
      await shot(page, "photo-1-preview");
      assert.ok(await page.getByTestId("draw-start").isDisabled());
      await page.getByTestId("laser-arm").click();
      await page.getByTestId("draw-start").click();
      await waitForState(page, "job", "running");
      await page.waitForTimeout(1500);
      await shot(page, "photo-2-running");
      await done(station);
      await waitForState(page, "job", "done", 10_000);
      const burnt = (await station.call("world.look")).strokes
        .filter((stroke) => stroke.burnt)
        .flatMap(({ points }) => points);
      const size = [0, 1].map(
        (axis) => Math.max(...burnt.map((point) => point[axis])) - Math.min(...burnt.map((point) => point[axis])),
      );
      assert.ok(burnt.length > 1000, `${burnt.length} points are burnt`);
      assert.ok(size.some((side) => near(side, 20, 1)) && size.some((side) => near(side, 25, 1)), `${size} mm`);
      assert.equal((await station.pose()).tool.laser, false);
      await page.goto(`${station.url}#/world`);
      await waitForState(page, "route", "world");
      await page.locator("[data-testid=world-paper] path.burnt[d*=M]").first().waitFor({ state: "attached" });
      await page.waitForTimeout(1200);
      await shot(page, "photo-3-world");
      // The portrait has greys: the hair is burnt deeper than the face.
      const [file] = await Promise.all([page.waitForEvent("download"), page.getByTestId("world-paper-save").click()]);
      const plate = readFileSync(await file.path(), "utf8");
      const sheet = await browser.browser.newPage({ viewport: { width: 640, height: 800 } });
      await sheet.setContent(
        `<body style="margin:0">${plate.slice(plate.indexOf("<svg")).replace(/ width="[^"]*" height="[^"]*"/, ' width="640" height="800"')}`,
      );
      await sheet.locator("svg").screenshot({ path: join(shots, "photo-4-plate.png") });
      await sheet.close();
      const powers = new Set((await station.call("world.look")).strokes.map((stroke) => stroke.power));
      assert.ok(powers.size > 20, `${powers.size} powers`);
      await page.context().close();
    } finally {
      await station.end();
    }
  });

  test("the first drawing on an arm of unknown table height, step by step", async () => {
    const folder = mkdtempSync(join(tmpdir(), "studio-first-"));
    const path = join(folder, "arm");
    const scenario = join(folder, "paper.toml");
    writeFileSync(
      scenario,
      `title = "Paper"\ntool = { kind = "pen" }\ntable = { height = ${PAPER}, x = [150, 320], y = [-150, 150] }\n`,
    );
    const picture = join(folder, "paper.svg");
    const sim = spawn(program, ["sim", "--pty", path, "--scenario", scenario, "--picture", picture, "--speed", "4"], {
      stdio: ["ignore", "pipe", "ignore"],
    });
    await new Promise((ready) => sim.stdout.once("data", ready));
    const station = new Station(program, ["--port", path]);
    await station.start();
    const over = new Promise((over) => sim.once("exit", over));
    try {
      const page = await browser.inControl(`${station.url}#/draw`);
      await waitForState(page, "route", "draw");
      assert.equal(await page.getByTestId("header-arm").textContent(), "Real arm");

      // After power-up the banner explains the state in words, and homes the arm.
      await page.getByTestId("alarm-banner").getByText("The arm was switched on").waitFor();
      assert.doesNotMatch(await page.getByTestId("alarm-banner").textContent(), /ResetOccurred/);
      await shot(page, "first-1-switched-on");
      // The height cannot be taken before homing. The message about that disappears after homing.
      await page.getByTestId("draw-text").fill("Mia");
      await page.getByTestId("touch-off").click();
      const refusal = page.locator(".touch-card").getByRole("alert");
      await refusal.getByText("not homed").waitFor();
      await page.getByTestId("alarm-home").click();
      await page.getByTestId("confirm-yes").click();
      await waitForState(page, "moving", "true");
      await waitForState(page, "moving", "false", 60_000);
      await waitForState(page, "alarm", "false", 60_000);
      await refusal.waitFor({ state: "detached" });

      // The message, its button, and the pad to lower the pen.
      await page.getByRole("alert").getByText("work surface height unknown").waitFor();
      await page.getByTestId("touch-off").waitFor();
      await shot(page, "first-2-unknown");
      await page.getByTestId("jog-mode-step").check({ force: true });
      for (const [step, until] of [
        ["10", 11],
        ["1", 1.05],
        ["0.1", 0.06],
      ]) {
        await page.getByTestId("jog-step-size").selectOption(step);
        for (let presses = 0; presses < 60; presses++) {
          const { z } = await station.waitForRest();
          if (z - PAPER < until) break;
          await page.getByTestId("jog-z-minus").click();
          await station.until("a step down", (state) => state.z < z - Number(step) / 2 && !state.moving);
        }
      }
      await shot(page, "first-3-at-the-paper");
      // The button beside the message acts like that of the card.
      await page.getByTestId("height-here").click();
      await page.waitForFunction(() =>
        /z -\d/.test(document.querySelector("[data-testid=touch-off-height]")?.textContent ?? ""),
      );
      const height = Number((await page.getByTestId("touch-off-height").textContent()).match(/-?[\d.]+/)[0]);
      assert.ok(near(height, PAPER, 0.11), `${height}`);
      await page.getByText("The arm can do it").waitFor();
      await shown(page);
      await shot(page, "first-4-preview");
      // The same place as used by `magician calibrate surface`.
      assert.match(readFileSync(join(station.state, "magician", "config.toml"), "utf8"), /^surface = -52\.\d+\n$/);

      await page.getByTestId("draw-start").click();
      await page.getByTestId("confirm-yes").click();
      await waitForState(page, "job", "running");
      await page.waitForTimeout(1500);
      await shot(page, "first-5-drawing");
      await done(station);
      await waitForState(page, "job", "done");
      const { z } = await station.waitForRest();
      assert.ok(z > height + 5, `the pen is at ${z}`);
      await shot(page, "first-6-done");
      // Two more touches, far apart, for a tilted table.
      const hop = async (button, by) => {
        await page.getByTestId("jog-step-size").selectOption("10");
        for (let pressed = 0; pressed < Math.abs(by) / 10; pressed++) {
          const before = await station.waitForRest();
          await page.getByTestId(`jog-${button}`).click();
          await station.until("a step", (state) => {
            const gone = Math.hypot(state.x - before.x, state.y - before.y, state.z - before.z);
            return gone > 9.9 && !state.moving;
          });
        }
      };
      await page.goto(`${station.url}#/move`);
      await waitForState(page, "route", "move");
      for (const [n, button, by] of [
        [2, "y-plus", 40],
        [3, "x-minus", 40],
      ]) {
        await hop(button, by);
        await page.getByTestId("touch-off-add").click();
        for (let tries = 0; (await station.call("surface.get")).touches !== n; tries++) {
          assert.ok(tries < 50, `touch ${n} is not taken`);
          await page.waitForTimeout(100);
        }
      }
      await page.getByTestId("touch-off-tilt").getByText("3 touches").waitFor();
      await page.goto(`${station.url}#/draw`);
      await waitForState(page, "route", "draw");
      await page.getByTestId("draw-text").fill("Mia");
      // After the height is deleted, the next drawing asks for it again.
      await page.getByTestId("touch-off-forget").click();
      await page.getByRole("alert").getByText("work surface height unknown").waitFor();
      await page.context().close();
    } finally {
      await station.end();
      sim.kill("SIGTERM");
    }
    await over;
    const drawn = readFileSync(picture, "utf8");
    assert.match(drawn, /<path/);
    const sheet = await browser.browser.newPage({ viewport: { width: 700, height: 900 } });
    await sheet.setContent(drawn.slice(drawn.indexOf("<svg")));
    await sheet.locator("svg").screenshot({ path: join(shots, "first-7-paper.png") });
    await sheet.close();
    rmSync(folder, { recursive: true, force: true });
  });

  test("three corners of the paper are touched, and a drawing lies on it upright for its reader", async () => {
    const folder = mkdtempSync(join(tmpdir(), "studio-paper-"));
    const path = join(folder, "arm");
    const sim = spawn(program, ["sim", "--pty", path, "--speed", "8"], { stdio: ["ignore", "pipe", "ignore"] });
    await new Promise((ready) => sim.stdout.once("data", ready));
    const station = new Station(program, ["--port", path]);
    await station.start();
    try {
      const page = await browser.inControl(`${station.url}#/move`, { viewport: { width: 390, height: 844 } });
      await page.getByTestId("alarm-home").click();
      await page.getByTestId("confirm-yes").click();
      await waitForState(page, "moving", "true");
      await waitForState(page, "moving", "false", 60_000);
      await page.getByRole("button", { name: "Measure the paper" }).click();
      const at = async (wanted) => {
        // With the pad beside the wizard: the wizard itself moves nothing.
        await page.getByTestId("jog-mode-step").check({ force: true });
        for (const [axis, to] of Object.entries(wanted)) {
          for (const size of [10, 5, 1]) {
            await page.getByTestId("jog-step-size").selectOption(String(size));
            for (let presses = 0; presses < 60; presses++) {
              const before = await station.waitForRest();
              const by = to - before[axis];
              if (Math.abs(by) < size * 0.99) break;
              await page.getByTestId(`jog-${axis}-${by > 0 ? "plus" : "minus"}`).click();
              await station.until(
                "a step",
                (state) => Math.abs(state[axis] - before[axis]) > size * 0.9 && !state.moving,
              );
            }
          }
        }
      };
      const stood = await station.waitForRest();
      await page.getByText("Corner 1 of 3: lower left").waitFor();
      const now = await station.waitForRest();
      assert.deepEqual([now.x, now.y, now.z], [stood.x, stood.y, stood.z], "nothing moves by itself");
      await at({ z: -50, x: 270, y: -40 });
      await page.getByRole("button", { name: "Take corner" }).click();
      await page.getByText("Corner 2 of 3: lower right").waitFor();
      // Touching the same corner twice is refused, and the first touch remains.
      await page.getByRole("button", { name: "Take corner" }).click();
      await page.getByRole("alert").filter({ hasText: "at least 30 mm" }).waitFor();
      assert.deepEqual((await station.call("surface.get")).corners, ["lower-left"]);
      await page.getByRole("button", { name: "Lift the pen 10 mm" }).click();
      await station.until("is lifted", (state) => near(state.z, -40, 1.1) && !state.moving);
      await at({ y: 40, z: -50 });
      await page.getByRole("button", { name: "Take corner" }).click();
      await page.getByText("Corner 3 of 3: upper left").waitFor();
      await shot(page, "paper-3");
      await at({ x: 220, y: -40 });
      await page.getByRole("button", { name: "Take corner" }).click();
      await page.getByText(/Paper \d+ × \d+ mm/).waitFor();
      const { sheet, plane } = await station.call("surface.get");
      assert.ok(
        near(sheet.rotation, 90, 2) && near(sheet.size[0], 80, 2) && near(sheet.size[1], 50, 2),
        JSON.stringify(sheet),
      );
      assert.ok(near(plane.z, -50, 1.1));
      // The same place as used by `magician calibrate sheet`.
      assert.match(readFileSync(join(station.state, "magician", "config.toml"), "utf8"), /^\[sheet\]/m);
      const check = { text: "Mia", format: "text", setup: { work: "draw", fit: true }, preview: true };
      const { preview } = await station.call("job.check", check);
      const points = preview.strokes.flatMap((stroke) => stroke.points);
      const [xs, ys] = [0, 1].map((axis) => points.map((point) => point[axis]));
      // Right in the file is right for the reader, which is +y.
      assert.ok(Math.max(...ys) - Math.min(...ys) > Math.max(...xs) - Math.min(...xs), "the text runs along y");
      // The page draws on the sheet, as large as it permits.
      await page.goto(`${station.url}#/draw`);
      await waitForState(page, "route", "draw");
      await page.getByTestId("draw-text").fill("Mia");
      await page.getByText("The arm can do it").waitFor();
      await shot(page, "paper-4");
      await page.getByTestId("draw-start").click();
      await page.getByTestId("confirm-yes").click();
      await waitForState(page, "job", "running");
      await done(station);
      const { drawn_mm } = (await station.call("job.list")).jobs.at(-1);
      assert.ok(drawn_mm > 120, `${drawn_mm} mm fill the paper`);
      await page.getByTestId("touch-off-forget").click();
      await page.getByText("The work surface is forgotten").waitFor();
      assert.equal((await station.call("surface.get")).sheet, null);
      await page.context().close();
    } finally {
      await station.end();
      sim.kill("SIGTERM");
      rmSync(folder, { recursive: true, force: true });
    }
  });
}
