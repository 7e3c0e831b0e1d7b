// Tests of the gallery: each example is started and checked in the virtual arm's world. Help and
// tour.
import assert from "node:assert/strict";
import { waitForState } from "./bench.mjs";

/** Position of an object's centre, rounded to centimetres; z to half centimetres. */
const placeOf = ({ objects }, name) => {
  const [x, y, z] = objects.find((object) => object.name === name).at;
  return [Math.round(x / 10) * 10, Math.round(y / 10) * 10, Math.round(z / 5) * 5];
};
const drawn = (least) => (look) => assert.ok(look.drawing.length > least, `${look.drawing.length} of drawing`);

/** Panel of each example, and its result in the world. */
const EXAMPLES = {
  draw: ["draw", drawn(10_000)],
  write: ["draw", drawn(1_000)],
  stamp: ["draw", drawn(800)],
  pick: ["teach", (look) => assert.deepEqual(placeOf(look, "red cube").slice(0, 2), [220, -130])],
  stack: [
    "teach",
    (look) => {
      const places = ["blue cube", "green cube", "red cube"].map((name) => placeOf(look, name));
      assert.deepEqual(
        places.map(([x, y]) => [x, y]),
        Array(3).fill([230, -40]),
      );
      assert.deepEqual(
        places.map(([, , z]) => z - places[0][2]),
        [0, 25, 50],
      );
    },
  ],
  belt: ["run", (look) => assert.ok(look.objects.every(({ at: [, y] }) => Math.abs(y + 200) < 15))],
  teach: ["teach", () => {}],
  playback: ["run", () => {}],
};

export function gallery(test, { browser, station, url }) {
  for (const [name, [panel, judge]] of Object.entries(EXAMPLES)) {
    test(`examples: ${name} runs after one press, in its scenario`, async () => {
      // As for a first visit, no arm is connected. The belt runs for a fixed time, which a busy
      // computer would miss at twenty times the speed.
      const page = await browser.page(`${url()}?speed=${name === "belt" ? 1 : 20}#/gallery`);
      await page.getByTestId(`gallery-${name}`).click();
      await waitForState(page, "route", panel, 20_000);
      await waitForState(page, "job", "done", 120_000);
      await station.join(page);
      judge(await station.call("world.look"));
      await page.context().close();
    });
  }

  test("examples: the laser engraves the photo", async () => {
    const page = await browser.page(`${url()}?speed=20#/gallery`);
    await page.getByTestId("gallery-engrave").click();
    await waitForState(page, "route", "engrave", 20_000);
    // Nothing burns before a person has armed the laser: not an example, and not what was stopped.
    await page.getByText("The arm can do it").waitFor({ timeout: 60_000 });
    assert.ok(await page.getByTestId("draw-start").isDisabled());
    await page.getByTestId("laser-arm").click();
    await page.getByTestId("draw-start").click();
    await waitForState(page, "job", "running", 60_000);
    await station.join(page);
    const burns = async () => ((await station.call("world.look")).strokes ?? []).some(({ burnt }) => burnt);
    for (let tries = 0; !(await burns()); tries++) {
      assert.ok(tries < 100, "nothing is burnt");
      await page.waitForTimeout(200);
    }
    await page.getByTestId("stop").click();
    await waitForState(page, "job", "stopped");
    for (const route of ["engrave", "move", "run"]) {
      await page.evaluate((route) => (location.hash = `#/${route}`), route);
      await waitForState(page, "route", route);
      assert.ok(await page.getByTestId("job-strip-pause").isDisabled(), route);
    }
    await page.getByTestId("strip-laser-arm").click();
    await page.getByTestId("job-strip-pause").click();
    await waitForState(page, "job", "running", 60_000);
    await page.getByTestId("stop").click();
    await page.context().close();
  });

  test("examples: the bad day shows its faults", async () => {
    const page = await browser.page(`${url()}?speed=5#/gallery`);
    await page.getByTestId("gallery-faults").click();
    // The cable is unplugged after twenty seconds of the arm's clock.
    await waitForState(page, "job", "interrupted", 60_000);
    await page.context().close();
  });

  test("help: beside every route, without a network, and closed where it was opened", async () => {
    const page = await browser.page(`${url()}#/draw`);
    const help = page.getByRole("button", { name: "Help", exact: true });
    await help.click();
    const shown = page.getByRole("complementary", { name: "Help" });
    await shown.getByRole("heading", { name: "Draw" }).waitFor();
    await page.evaluate(() => navigator.serviceWorker.ready);
    await page.context().setOffline(true);
    await page.goto(`${url()}#/teach`);
    await shown.getByRole("heading", { name: "Teach" }).waitFor();
    await page.context().setOffline(false);
    await page.getByRole("button", { name: "Close help" }).click();
    await shown.waitFor({ state: "detached" });
    await page.waitForFunction(() => document.activeElement?.dataset.testid === "help");
    await page.context().close();
  });

  test("tour: by keyboard from beginning to end, and nothing moves", async () => {
    const page = await browser.page(`${url()}#/move`);
    await page.getByTestId("connect-sim").click();
    await waitForState(page, "lease", "mine");
    await station.join(page);
    const before = await station.waitForRest();
    await page.getByTestId("help").click();
    await page.getByTestId("tour").click();
    const card = page.getByTestId("tour-card");
    await card.waitFor();
    let steps = 0;
    for (; await card.isVisible(); steps++) {
      assert.ok(steps < 20);
      await page.keyboard.press("Enter");
      await page.waitForTimeout(50);
    }
    assert.ok(steps >= 6, `${steps} steps`);
    const { x, y, z } = await station.waitForRest();
    assert.deepEqual([x, y, z], [before.x, before.y, before.z]);
    await page.context().close();
  });
}

/** The examples at a station whose virtual arm is free. */
export function galleryAtStation(test, { browser, station }) {
  test("examples: at a station one press takes control that is free, and runs", async () => {
    const page = await browser.page(`${station.url}#/gallery`);
    await page.getByTestId("gallery-write").click();
    await waitForState(page, "job", "running", 30_000);
    await waitForState(page, "route", "draw");
    await page.getByTestId("stop").click();
    await waitForState(page, "job", "stopped");
    await page.getByTestId("lease-release").click();
    await waitForState(page, "lease", "free");
    await page.context().close();
  });
}
