// A running job is shown on every route to every user, and can be controlled there. A route opens
// at its top, and Back restores the scroll position.
import assert from "node:assert/strict";
import { near, waitForState } from "./bench.mjs";

const SIZES = { phone: { width: 390, height: 844 }, tablet: { width: 1024, height: 768 } };
const ROUTES = ["move", "teach", "run", "io", "plots", "world", "class", "arms", "settings"];

export function strips(test, { browser, station, closePage }) {
  const job = async () => (await station.call("job.list")).jobs.at(-1);
  const to = async (page, route) => {
    await page.evaluate((route) => (location.hash = `#/${route}`), route);
    await waitForState(page, "route", route);
  };
  /** Draws a text from the page, long enough to be observed. */
  const drawing = async (page, text) => {
    await waitForState(page, "route", "draw");
    await page.getByTestId("draw-text").fill(text);
    await page.getByText("The arm can do it").waitFor();
    await page.getByTestId("draw-start").click();
    await waitForState(page, "job", "running");
  };

  for (const [size, viewport] of Object.entries(SIZES)) {
    test(`a running job is paused, resumed and stopped from any route: ${size}`, async () => {
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
      await waitForState(page, "job", "paused");
      await to(page, "settings");
      await strip.getByRole("button", { name: "Resume" }).click();
      await waitForState(page, "job", "running");
      const { width, height } = await page.getByTestId("job-strip-stop").boundingBox();
      assert.ok(width >= 44 && height >= 44);
      await strip.getByRole("button", { name: "Stop job" }).click();
      await waitForState(page, "job", "stopped");
      assert.equal((await job()).state, "stopped");
      await strip.getByText(/stopped at \d+ %/).waitFor();
      await strip.getByRole("button", { name: "Close" }).click();
      await strip.waitFor({ state: "detached" });
      await closePage(page);
    });
  }

  test("a page without control sees the job and why its buttons are disabled", async () => {
    const page = await browser.inControl(`${station.url}#/draw`);
    const other = await browser.connected(`${station.url}#/move`);
    await drawing(page, "Look");
    const strip = other.getByTestId("job-strip");
    await strip.getByText("Look", { exact: true }).waitFor();
    const pause = other.getByTestId("job-strip-pause");
    assert.ok(await pause.isDisabled());
    const why = await pause.getAttribute("aria-describedby");
    assert.match(await other.locator(`#${why}`).textContent(), /Someone else has control/);
    // Any user may stop the job.
    await other.getByTestId("job-strip-stop").click();
    await waitForState(page, "job", "stopped");
    await other.context().close();
    await page.getByTestId("job-strip-close").click();
    await closePage(page);
  });

  test("a finished job shows its duration, and disappears without user activity", async () => {
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
    // The pressed element remains in place, and the sheet is visible beside it.
    assert.ok(near(await top(), before, 2), `${before} and ${await top()}`);
    const sheet = await page.locator(".sheet-card").boundingBox();
    assert.ok(sheet.y > 0 && sheet.y + sheet.height < SIZES.phone.height, "the sheet is seen");
    await waitForState(page, "job", "done", 60_000);
    await page.getByText(/done in 0:\d\d/).waitFor();
    await page.getByTestId("job-strip").waitFor({ state: "detached", timeout: 20_000 });
    await page.waitForTimeout(300);
    assert.ok(near(await top(), before, 2), `${before} and ${await top()}`);
    await closePage(page);
  });

  test("a route opens at its top, and Back restores the scroll position", async () => {
    const page = await browser.inControl(`${station.url}#/move`, { viewport: SIZES.phone });
    const place = () => page.evaluate(() => Math.round(scrollY));
    await page.evaluate(() => scrollTo(0, 700));
    await page.waitForFunction(() => scrollY > 600);
    // The visible position counts, since a picture that loads later moves the content below it.
    const top = (id) => page.getByTestId(id).evaluate((one) => one.getBoundingClientRect().top);
    const left = await top("jog-y-plus");
    await page.getByRole("link", { name: "Teach" }).click();
    await waitForState(page, "route", "teach");
    assert.equal(await place(), 0);
    await page.waitForFunction(() => document.body.scrollHeight > 1800);
    await page.evaluate(() => scrollTo(0, 300));
    // The browser reports scrolling with the next frame.
    await page.waitForTimeout(500);
    await page.goBack();
    await waitForState(page, "route", "move");
    await page.waitForTimeout(1500);
    assert.ok(near(await top("jog-y-plus"), left, 40), `${left} and ${await top("jog-y-plus")}`);
    await page.goForward();
    await waitForState(page, "route", "teach");
    await page.waitForFunction(() => Math.abs(scrollY - 300) < 60);
    await closePage(page);
  });
}
