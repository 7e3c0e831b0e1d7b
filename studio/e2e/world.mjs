// Tests of a virtual arm's world, and of its pins: actions of the page, and the station's state
// afterwards.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { near, waitForState } from "./bench.mjs";

/** Waits until the result of a call meets a condition. */
async function until(station, method, params, what, is) {
  const ends = Date.now() + 10_000;
  for (;;) {
    const answer = await station.call(method, params);
    if (is(answer)) return answer;
    assert.ok(Date.now() < ends, `${what}: ${JSON.stringify(answer)}`);
    await new Promise((done) => setTimeout(done, 100));
  }
}

export function worlds(test, { browser, station, shots, closePage }) {
  const look = (what, is) => until(station, "world.look", {}, what, is);
  const cube = (seen, name = "blue cube") => seen.objects.find((object) => object.name === name);
  const open = async (route, options) => {
    const page = await browser.inControl(`${station.url}#/${route}`, options);
    await waitForState(page, "route", route);
    return page;
  };
  const begin = async (page, name, title) => {
    await page.getByTestId("world-scenario").selectOption(name);
    await look(title, (seen) => seen.title === title);
  };

  test("world: a scenario begins, and a cube is dragged by pointer and by keyboard", async () => {
    const page = await open("world");
    await begin(page, "cubes", "Three cubes");
    await page.getByTestId("world-object-blue cube").waitFor();
    await page.locator("[data-testid=view][data-camera]").waitFor();
    // The picture has its final size and is at rest.
    await page.waitForFunction(
      () => {
        const { camera } = document.querySelector("[data-testid=view]").dataset;
        const same = window.before === camera;
        window.before = camera;
        return same;
      },
      undefined,
      { polling: 400 },
    );
    const { camera, box } = await page.getByTestId("view").evaluate((view) => ({
      camera: view.dataset.camera.split(",").map(Number),
      box: view.getBoundingClientRect().toJSON(),
    }));
    const at = ([x, y, z]) => {
      const row = (nth) => camera[nth] * x + camera[nth + 4] * y + camera[nth + 8] * z + camera[nth + 12];
      return [box.x + ((row(0) / row(3) + 1) / 2) * box.width, box.y + ((1 - row(1) / row(3)) / 2) * box.height];
    };
    // Grabs the centre of the cube's top, and moves it by 50 mm.
    await page.mouse.move(...at([230, -40, -35]));
    await page.locator(".view.grabs").waitFor();
    await page.mouse.down();
    await page.mouse.move(...at([200, -80, -35]), { steps: 4 });
    await page.mouse.up();
    await look(
      "dragged",
      (seen) => near(cube(seen).at[0], 200, 3) && near(cube(seen).at[1], -80, 3) && cube(seen).at[2] === -60,
    );
    const field = page.getByRole("spinbutton", { name: "y of blue cube, mm" });
    await field.fill("-120");
    await field.press("Enter");
    await look("typed", (seen) => cube(seen).at[1] === -120);
    await page.setViewportSize({ width: 1280, height: 860 });
    await page.getByTestId("notice").locator("p").waitFor({ state: "hidden" });
    await page.screenshot({ path: join(shots, "world.png") });
    await closePage(page);
  });

  test("world: what the pen draws is on the paper", async () => {
    const page = await open("world");
    await begin(page, "drawing", "Drawing");
    const lease = await page.getByTestId("lease-release").isVisible();
    assert.ok(lease);
    assert.equal(await page.getByTestId("world-paper").locator("path[d*=M]").count(), 0);
    await page.getByTestId("world-paper-none").getByText("Nothing drawn yet").waitFor();
    await page.getByTestId("clear-alarms").or(page.getByTestId("stop")).first().waitFor();
    await page.getByTestId("lease-release").click();
    await waitForState(page, "lease", "free");
    for (const to of [
      [220, -40, -20, 0],
      [220, -40, -60, 0],
      [260, 40, -60, 0],
      [260, 40, -20, 0],
    ]) {
      await station.call("arm.move", { to, by: "linear" });
    }
    const { strokes } = await look("a line", (seen) => seen.strokes.length > 0);
    await page.locator("[data-testid=world-paper] path.ink[d^=M]").waitFor({ state: "attached" });
    const drawn = await page.locator("[data-testid=world-paper] path.ink").getAttribute("d");
    const [x, y] = strokes[0].points.at(-1);
    assert.ok(drawn.endsWith(`${x} ${y}`), `${drawn} and ${x} ${y}`);
    assert.match(await page.getByTestId("world-paper").evaluate((paper) => paper.tagName), /^svg$/i);
    await page.context().close();
  });

  test("world: manual unlock, guiding, unplugging, and faults", async () => {
    const page = await open("world");
    await page.getByRole("switch", { name: "Unlock key held" }).click();
    await look("unlocked", (seen) => seen.unlocked);
    await page.getByTestId("world-guide-j1").fill("20");
    await station.until("guided", (state) => near(state.j1, 20));
    await page.getByTestId("world-unlock").click();
    await look("locked", (seen) => !seen.unlocked);
    await page.getByTestId("world-plugged").click();
    await waitForState(page, "link", "lost");
    await page.getByTestId("world-plugged").click();
    await waitForState(page, "link", "up");
    await page.getByTestId("world-alarm").click();
    await page.getByTestId("alarm-64").waitFor();
    const { alarms } = await station.call("arm.alarms");
    const said = await page.getByTestId("alarm-64").textContent();
    for (const part of ["name", "cause", "cure"])
      assert.ok(said.includes(alarms.find(({ code }) => code === 64)[part]), `${part}: ${said}`);
    assert.ok(await page.getByTestId("alarm-clear").isEnabled());
    await page.goto(`${station.url}#/move`);
    await page.getByTestId("clear-alarms").click();
    await waitForState(page, "alarm", "false");
    await closePage(page);
  });

  test("world: a file that is no scenario is refused with its line", async () => {
    const page = await open("world");
    const file = { name: "bad.toml", mimeType: "text/plain", buffer: Buffer.from("[table]\nheigth = -70") };
    await page.getByTestId("world-scenario-open").setInputFiles(file);
    await page.getByTestId("notice").getByText("line 2").waitFor();
    await closePage(page);
  });

  test("fence: it is shown in the picture, in the settings and where the arm is moved", async () => {
    const out = { x: [150, 220], y: [80, 160], z: [-60, 40] };
    await station.call("arm.fence", { set: { box: { x: [0, 330], y: [-250, 250], z: [-100, 200] }, keep_out: [out] } });
    const init = () => {
      HTMLCanvasElement.prototype.getContext = () => null;
    };
    for (const route of ["move", "settings"]) {
      const page = await browser.connected(`${station.url}#/${route}`, { init });
      const rect = page.locator(".plan rect[fill='var(--stop)']");
      await rect.waitFor({ state: "attached" });
      const said = await rect.evaluate((rect) => [
        rect.getAttribute("transform"),
        rect.getAttribute("width"),
        rect.getAttribute("height"),
      ]);
      assert.deepEqual(said, ["translate(185 120) rotate(0)", "70", "80"]);
      // For a reader in front of the arm, y is to the right and x down.
      const [box, base] = [await rect.boundingBox(), await page.locator(".plan .base").boundingBox()];
      assert.ok(box.x > base.x + base.width / 2 && box.y > base.y + base.height, JSON.stringify([box, base]));
      assert.ok(near(box.width / box.height, 80 / 70, 0.02), JSON.stringify(box));
      await page.context().close();
    }
    await station.call("arm.fence", { set: null });
    const page = await browser.connected(`${station.url}#/move`, { init });
    await page.locator(".plan .base").waitFor();
    assert.equal(await page.locator(".plan rect:not(.base)").count(), 0);
    await page.context().close();
  });

  test("pins: a function, a level and volts, as the station reads them", async () => {
    const page = await open("io");
    await page.getByTestId("pin-2-function").selectOption("1");
    await page.getByTestId("pin-2-set").click();
    await page.getByTestId("pin-2-level").getByText("1", { exact: true }).waitFor();
    assert.equal((await station.call("arm.io")).pins[1].level, 1);
    await page.getByTestId("pin-9-function").selectOption({ label: "Analog input" });
    await page.getByTestId("pin-9-drive").fill("3850");
    await page.getByTestId("pin-9-level").getByText("3.1 V").waitFor();
    assert.equal((await station.call("arm.get", { command: "IOADC", query: { address: 9 } })).value, 3850);
    // Functions that a connector does not support cannot be selected.
    assert.ok(await page.locator("[data-testid=pin-5-function] option[value='1']").isDisabled());
    assert.equal(await page.getByRole("table", { name: "Pins" }).getByRole("row").count(), 21);
    await page.screenshot({ path: join(shots, "io.png") });
    await page.getByTestId("pin-2-function").selectOption("0");
    await page.getByTestId("pin-2-set").waitFor({ state: "detached" });
    assert.equal((await station.call("arm.io")).pins[1].function, 0);
    await closePage(page);
  });

  test("plots: two minutes of history, paused, and saved in the format of record", async () => {
    const page = await browser.connected(`${station.url}#/move`);
    // The ring buffer is filled on any route.
    for (const to of [
      [220, 60, 40, 20],
      [250, -40, 0, 0],
    ])
      await station.call("arm.move", { to });
    await page.goto(`${station.url}#/plots`);
    await page.locator("[data-testid=plot][data-rows] canvas").waitFor();
    const plot = page.getByRole("img", { name: "Readings over time" });
    const rows = async () => Number(await plot.getAttribute("data-rows"));
    await station.call("arm.move", { to: [230, 30, 20, 0] });
    await page.waitForTimeout(300);
    assert.ok((await rows()) > 30, `${await rows()} rows`);
    const ms = Number(await plot.getAttribute("data-ms"));
    assert.ok(ms < 30, `${ms} ms for a drawing`);
    await page.getByTestId("plot-pause").click();
    const held = await page.getByTestId("plot-table").textContent();
    await station.call("arm.move", { to: [220, 0, 40, 0] });
    assert.equal(await page.getByTestId("plot-table").textContent(), held);
    await page.screenshot({ path: join(shots, "plots.png") });
    const before = await rows();
    await page.getByTestId("plot-scrub").fill("-1");
    await page.waitForFunction(
      (before) => Number(document.querySelector("[data-testid=plot]").dataset.rows) < before,
      before,
    );
    const [download] = await Promise.all([page.waitForEvent("download"), page.getByTestId("plot-export").click()]);
    const [head, ...lines] = readFileSync(await download.path(), "utf8")
      .trim()
      .split("\n");
    assert.equal(head, "time,t,x,y,z,r,j1,j2,j3,j4,index,left_space,alarms");
    const [time] = lines[0].split(",");
    assert.ok(Math.abs(Date.parse(time) - Date.now()) < 600_000, time);
    const readings = lines.map((line) => line.split(",").slice(1).map(Number));
    assert.equal(readings[0][0], 0);
    // The arm was there while another route was open.
    assert.ok(readings.some(([, x, y]) => near(x, 250) && near(y, -40)));
    assert.ok(readings.every(([t], row) => row === 0 || t > readings[row - 1][0]));
    await page.context().close();
  });

  test("pins: a stepper drives the belt and a sensor is read, by the commands of the table", async () => {
    const { scenarios } = await station.call("world.scenarios");
    await station.call("world.scenario", { text: scenarios.find(({ name }) => name === "pick_and_sort").text });
    const page = await open("io");
    const stepper = page.getByRole("form", { name: "Stepper: run", exact: true });
    await stepper.getByRole("spinbutton").fill("5000");
    await stepper.getByRole("button", { name: "Send" }).click();
    await look("the belt runs", (seen) => seen.belt.travel > 1);
    await stepper.getByRole("checkbox").uncheck();
    await stepper.getByRole("button", { name: "Send" }).click();
    const infrared = page.getByRole("form", { name: "Infrared sensor" });
    await infrared.getByRole("button", { name: "Send" }).click();
    await infrared.getByRole("button", { name: "Read" }).click();
    await infrared.getByText("Object in front").waitFor();
    await infrared.getByRole("button", { name: "Reading" }).click();
    await closePage(page);
    // The following tests need an arm in an empty world.
    await station.call("world.scenario", { text: "" });
    await station.call("arm.clear_alarms");
  });
}
