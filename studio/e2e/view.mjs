// Tests of the arm's picture: its first view, the camera, and moving to a pose that is typed or
// pressed in it.
import assert from "node:assert/strict";
import { join } from "node:path";
import { near } from "./bench.mjs";

const SIZES = { phone: [390, 844], tablet: [1024, 768], desktop: [1440, 900] };

/** Positions of the arm's points in the picture, px from its upper left corner, and its size. */
async function project(page, points) {
  return page.getByTestId("view").evaluate((view, points) => {
    const camera = view.dataset.camera.split(",").map(Number);
    const at = ([x, y, z]) => {
      const row = (nth) => camera[nth] * x + camera[nth + 4] * y + camera[nth + 8] * z + camera[nth + 12];
      return [((row(0) / row(3) + 1) / 2) * view.clientWidth, ((1 - row(1) / row(3)) / 2) * view.clientHeight];
    };
    return { at: points.map(at), width: view.clientWidth, height: view.clientHeight };
  }, points);
}

/** Waits until the camera of the picture is at rest. */
async function waitForStillPicture(page) {
  await page.locator("[data-testid=view][data-camera]").waitFor();
  await page.waitForFunction(
    () => {
      const { camera } = document.querySelector("[data-testid=view]").dataset;
      const same = window.before === camera;
      window.before = camera;
      return same;
    },
    undefined,
    { polling: 500 },
  );
}

/** Waits until the picture meets a condition: on a busy machine a camera flight takes long. */
async function waitUntil(what, is) {
  for (const ends = Date.now() + 15_000; !(await is()); await new Promise((over) => setTimeout(over, 200)))
    assert.ok(Date.now() < ends, what);
}

export function views(test, { browser, station, shots, closePage }) {
  const loadScenario = async (name) => {
    const { scenarios } = await station.call("world.scenarios");
    await station.call("world.scenario", { text: scenarios.find((one) => one.name === name)?.text ?? "" });
    await station.call("arm.clear_alarms");
  };
  const shot = (page, name) => page.screenshot({ path: join(shots, `${name}.png`) });
  const cubes = async () => (await station.call("world.look")).objects.map(({ at }) => at);

  test("view: the first picture is from in front and shows what is on the table, at every size", async () => {
    await loadScenario("cubes");
    const things = [...(await cubes()), [-79, -79, -62], [-79, 79, -62], [340, 200, -60], [340, -200, -60]];
    for (const [size, [width, height]] of Object.entries(SIZES)) {
      const page = await browser.connected(`${station.url}#/move`, {
        viewport: { width, height },
        reducedMotion: "reduce",
      });
      await page.getByTestId("view-fit").waitFor();
      await waitForStillPicture(page);
      // The camera buttons cover none of the content.
      await waitUntil(`${size}: all is in the picture`, async () => {
        const { at, width: wide, height: high } = await project(page, things);
        const [bar, view] = [
          await page.getByTestId("view-corner").boundingBox(),
          await page.getByTestId("view").boundingBox(),
        ];
        const low = Math.min(high, bar.y - view.y + 4);
        return at.every(([x, y]) => x >= 0 && x <= wide && y >= 0 && y <= low);
      });
      // In front of the arm +y is to the right, and points in front of the arm are nearer to the
      // reader.
      const { at } = await project(page, [
        [250, -100, -60],
        [250, 100, -60],
        [0, 0, -60],
      ]);
      assert.ok(at[0][0] < at[1][0] && at[2][1] < at[0][1] && at[2][1] < at[1][1], `${size}: ${JSON.stringify(at)}`);
      for (const name of ["view-fit", "view-zoom-in", "view-zoom-out", "view-top"]) {
        const box = await page.getByTestId(name).boundingBox();
        if (size === "phone") assert.ok(box.width >= 44 && box.height >= 44, `${name}: ${JSON.stringify(box)}`);
      }
      await shot(page, `view-first-${size}`);
      await page.context().close();
    }
  });

  test("view: another scenario is framed again, unless the user has turned the picture; one press shows all", async () => {
    await loadScenario("drawing");
    const page = await browser.connected(`${station.url}#/move`);
    await page.getByTestId("view-fit").waitFor();
    await waitForStillPicture(page);
    const camera = () => page.getByTestId("view").getAttribute("data-camera");
    const first = await camera();
    await loadScenario("pick_and_sort");
    await page.waitForFunction((first) => document.querySelector("[data-testid=view]").dataset.camera !== first, first);
    await waitForStillPicture(page);
    // The user turns the picture.
    const box = await page.getByTestId("view").boundingBox();
    await page.mouse.move(box.x + box.width / 2, box.y + 40);
    await page.mouse.down();
    await page.mouse.move(box.x + box.width / 2 + 120, box.y + 60, { steps: 5 });
    await page.mouse.up();
    await page.locator("[data-testid=view-corner][aria-pressed=false]").waitFor();
    await waitForStillPicture(page);
    const turned = await camera();
    await loadScenario("cubes");
    await page.waitForTimeout(2500);
    await waitForStillPicture(page);
    // The new scenario must not move the camera. The tolerance allows for the damped end of the
    // turn.
    const [one, other] = [turned, await camera()].map((text) => text.split(",").map(Number));
    assert.ok(
      one.every((value, nth) => near(value, other[nth], 1)),
      `${one} and ${other}`,
    );
    const corners = [...(await cubes()), [340, 200, -60], [340, -200, -60]];
    const widest = async () => {
      const { at, width, height } = await project(page, corners);
      return Math.max(...at.map(([x, y]) => Math.max(Math.abs(x / width - 0.5), Math.abs(y / height - 0.5))));
    };
    const before = await widest();
    const zoom = async (way, times) => {
      for (let presses = 0; presses < times; presses++) await page.getByRole("button", { name: `Zoom ${way}` }).click();
    };
    await zoom("in", 1);
    await waitUntil("is nearer", async () => (await widest()) > before * 1.1);
    await zoom("out", 3);
    await waitUntil("is farther", async () => (await widest()) < before);
    await zoom("in", 8);
    await waitUntil("is too near for all", async () => (await widest()) > 0.5);
    await page.getByRole("button", { name: "Show all" }).click();
    await waitUntil("shows all", async () => (await widest()) <= 0.5);
    await page.context().close();
  });

  test("move: a pose is typed, refused with its reason, and gone to; nothing moves before Go", async () => {
    await loadScenario("cubes");
    const page = await browser.inControl(`${station.url}#/move`);
    const press = (name) => page.getByRole("button", { name, exact: true }).click();
    const field = (name) => page.getByRole("textbox", { name, exact: true });
    const before = await station.waitForRest();
    await press("Go to …");
    // The fields contain the current pose.
    assert.ok(
      near(Number(await field("x").inputValue()), before.x) && near(Number(await field("z").inputValue()), before.z),
    );
    await field("x").fill("500");
    await page.getByTestId("goto-said").getByText("out of reach").waitFor();
    assert.ok(await page.getByRole("button", { name: "Go", exact: true }).isDisabled());
    await field("x").fill("22o");
    await page.getByTestId("goto-said").getByText("Each field is a number").waitFor();
    assert.equal(await field("x").getAttribute("aria-invalid"), "true");
    await field("x").fill("220");
    await field("y").fill("80,5");
    await field("z").fill("10");
    await field("r").fill("30");
    await page.getByText("Nothing moves before you press Go.").waitFor();
    await page.waitForFunction(() => !document.querySelector("[data-testid=goto-start]").disabled);
    const still = await station.waitForRest();
    assert.ok(near(still.x, before.x) && near(still.y, before.y), "it moved before Go");
    await shot(page, "view-goto");
    await press("Go");
    await station.until(
      "is there",
      (state) => near(state.x, 220) && near(state.y, 80.5) && near(state.z, 10) && near(state.r, 30),
    );
    // Copies the pose, moves away, and pastes it into one of the fields.
    await page.context().grantPermissions(["clipboard-read", "clipboard-write"]);
    await page.waitForFunction(() => document.querySelector("[data-testid=pose-x]").textContent === "220.00");
    await press("Copy pose");
    assert.equal(await page.evaluate(() => navigator.clipboard.readText()), "220, 80.5, 10, 30");
    await field("y").fill("-80");
    await page.waitForFunction(() => !document.querySelector("[data-testid=goto-start]").disabled);
    await press("Go");
    await station.until("is there", (state) => near(state.y, -80));
    await field("z").focus();
    await page.keyboard.press("Control+V");
    assert.equal(await field("y").inputValue(), "80.5");
    await press("Close");
    await page.getByTestId("goto-x").waitFor({ state: "detached" });
    await closePage(page);
  });

  test("move: a press on the table from above sets x and y, with and without WebGL", async () => {
    await loadScenario("cubes");
    for (const flat of [false, true]) {
      const init = () => {
        HTMLCanvasElement.prototype.getContext = () => null;
      };
      const page = await browser.inControl(`${station.url}#/move`, flat ? { init } : {});
      await page.getByTestId("goto").click();
      await page.getByTestId("goto-z").fill("20");
      const view = page.getByTestId("view");
      const box = await view.boundingBox();
      const before = await station.waitForRest();
      if (!flat) {
        // In the corner view a press turns the picture, and sets nothing.
        await page.getByTestId("view-fit").waitFor();
        await waitForStillPicture(page);
        const x = await page.getByTestId("goto-x").inputValue();
        await view.click({ position: { x: box.width / 2, y: box.height / 2 } });
        assert.equal(await page.getByTestId("goto-x").inputValue(), x);
        await page.getByTestId("view-top").click();
        await waitForStillPicture(page);
      }
      // In the flat picture the scale is measured from the positions of tip and base.
      const place = flat
        ? await page.locator(".plan .base").evaluate((base) => {
            const [one, outer] = [
              base.getBoundingClientRect(),
              document.querySelector("[data-testid=view]").getBoundingClientRect(),
            ];
            const scale = one.width / 158;
            return [one.x - outer.x + one.width / 2 - 60 * scale, one.y - outer.y + one.height / 2 + 200 * scale];
          })
        : (await project(page, [[200, -60, -60]])).at[0];
      await view.click({ position: { x: place[0], y: place[1] } });
      await page.waitForFunction(() => Math.abs(document.querySelector("[data-testid=goto-x]").value - 200) < 2);
      assert.ok(near(Number(await page.getByTestId("goto-y").inputValue()), -60, 2), `${flat}`);
      if (flat) await page.locator(".plan .goal").waitFor();
      const still = await station.waitForRest();
      assert.ok(near(still.x, before.x) && near(still.y, before.y), "it moved before Go");
      await page.waitForFunction(() => !document.querySelector("[data-testid=goto-start]").disabled);
      await shot(page, `view-press-${flat ? "plan" : "top"}`);
      await page.getByTestId("goto-start").click();
      await station.until("is there", (state) => near(state.x, 200, 2) && near(state.y, -60, 2) && near(state.z, 20));
      await closePage(page);
    }
    await loadScenario("");
  });
}
