// A running job is seen on every route, by everybody, and steered there; a route opens at its top, and Back leads to where it was left.
import assert from "node:assert/strict";
import { is, near } from "./bench.mjs";

const SIZES = { phone: { width: 390, height: 844 }, tablet: { width: 1024, height: 768 } };
const ROUTES = ["move", "teach", "run", "io", "plots", "world", "class", "arms", "settings"];

export function strips(test, { browser, station, closed }) {
  const job = async () => (await station.call("job.list")).jobs.at(-1);
  const to = async (page, route) => {
    await page.evaluate((route) => (location.hash = `#/${route}`), route);
    await is(page, "route", route);
  };
  /** A text is drawn from the page, long enough to be looked at. */
  const drawing = async (page, text) => {
    await is(page, "route", "draw");
    await page.getByTestId("draw-text").fill(text);
    await page.getByText("The arm can do it").waitFor();
    await page.getByTestId("draw-start").click();
    await is(page, "job", "running");
  };

  for (const [size, viewport] of Object.entries(SIZES)) {
    test(`a running job is paused, gone on with and stopped from any route: ${size}`, async () => {
      const page = await browser.inControl(`${station.url}#/draw`, { viewport });
      await drawing(page, "Mia and Ben");
      const strip = page.getByRole("region", { name: "Job" });
      await strip.getByText("Mia and Ben", { exact: true }).waitFor();
      assert.equal((await job()).title, "Mia and Ben", "its text is its title");
      for (const route of ROUTES) {
        await to(page, route);
        const box = await strip.boundingBox();
        const stop = await page.getByTestId("stop").boundingBox();
        assert.ok(box.y >= stop.y + stop.height && box.y + box.height < viewport.height / 3, route);
        await strip.getByText(/\d+ %/).waitFor();
      }
      await strip.getByRole("button", { name: "Pause" }).click();
      await is(page, "job", "paused");
      await to(page, "settings");
      await strip.getByRole("button", { name: "Resume" }).click();
      await is(page, "job", "running");
      const { width, height } = await page.getByTestId("job-strip-stop").boundingBox();
      assert.ok(width >= 44 && height >= 44);
      await strip.getByRole("button", { name: "Stop job" }).click();
      await is(page, "job", "stopped");
      assert.equal((await job()).state, "stopped");
      await strip.getByText(/stopped at \d+ %/).waitFor();
      await strip.getByRole("button", { name: "Close" }).click();
      await strip.waitFor({ state: "detached" });
      await closed(page);
    });
  }

  test("who has no control sees the job and why it cannot be steered", async () => {
    const page = await browser.inControl(`${station.url}#/draw`);
    const other = await browser.connected(`${station.url}#/move`);
    await drawing(page, "Look");
    const strip = other.getByTestId("job-strip");
    await strip.getByText("Look", { exact: true }).waitFor();
    const pause = other.getByTestId("job-strip-pause");
    assert.ok(await pause.isDisabled());
    const why = await pause.getAttribute("aria-describedby");
    assert.match(await other.locator(`#${why}`).textContent(), /Someone else has control/);
    // A stop is anybody's.
    await other.getByTestId("job-strip-stop").click();
    await is(page, "job", "stopped");
    await other.context().close();
    await page.getByTestId("job-strip-close").click();
    await closed(page);
  });

  test("a job that is done says how long it took, and goes when no hand is at the page", async () => {
    const page = await browser.inControl(`${station.url}#/draw`, { viewport: SIZES.phone });
    await page.getByTestId("draw-text").fill("i");
    await page.getByText("The arm can do it").waitFor();
    const start = page.getByTestId("draw-start");
    await start.scrollIntoViewIfNeeded();
    const top = () => start.evaluate((button) => button.getBoundingClientRect().top);
    const before = await top();
    await start.click();
    await page.getByTestId("job-strip").waitFor();
    await page.waitForTimeout(300);
    // What was pressed stays where it was, and the sheet is in sight beside it.
    assert.ok(near(await top(), before, 2), `${before} and ${await top()}`);
    const sheet = await page.locator(".sheet-card").boundingBox();
    assert.ok(sheet.y > 0 && sheet.y + sheet.height < SIZES.phone.height, "the sheet is seen");
    await is(page, "job", "done", 60_000);
    await page.getByText(/done in 0:\d\d/).waitFor();
    await page.getByTestId("job-strip").waitFor({ state: "detached", timeout: 20_000 });
    await page.waitForTimeout(300);
    assert.ok(near(await top(), before, 2), `${before} and ${await top()}`);
    await closed(page);
  });

  test("a route opens at its top, and Back leads to where it was left", async () => {
    const page = await browser.inControl(`${station.url}#/move`, { viewport: SIZES.phone });
    const place = () => page.evaluate(() => Math.round(scrollY));
    await page.evaluate(() => scrollTo(0, 700));
    await page.waitForFunction(() => scrollY > 600);
    // What is seen counts: a picture that comes later moves what is below it.
    const top = (id) => page.getByTestId(id).evaluate((one) => one.getBoundingClientRect().top);
    const left = await top("jog-y-plus");
    await page.getByRole("link", { name: "Teach" }).click();
    await is(page, "route", "teach");
    assert.equal(await place(), 0);
    await page.waitForFunction(() => document.body.scrollHeight > 1800);
    await page.evaluate(() => scrollTo(0, 300));
    // The browser tells of it with the next picture.
    await page.waitForTimeout(500);
    await page.goBack();
    await is(page, "route", "move");
    await page.waitForTimeout(1500);
    assert.ok(near(await top("jog-y-plus"), left, 40), `${left} and ${await top("jog-y-plus")}`);
    await page.goForward();
    await is(page, "route", "teach");
    await page.waitForFunction(() => Math.abs(scrollY - 300) < 60);
    await closed(page);
  });
}
