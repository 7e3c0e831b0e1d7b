// Layout of the studio: no horizontal scrolling, no findings of axe, and screenshots for review.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";
import { setTimeout as sleep } from "node:timers/promises";
import { waitForState } from "./bench.mjs";

const ROUTES = [
  "move",
  "gallery",
  "teach",
  "draw",
  "engrave",
  "run",
  "io",
  "plots",
  "world",
  "class",
  "arms",
  "settings",
];
const SIZES = { phone: [360, 740], tablet: [768, 1024], desktop: [1280, 860], "at-200": [640, 450] };
const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");

export async function findings(page) {
  await page.evaluate(axe);
  const { violations } = await page.evaluate(() => window.axe.run(document, { resultTypes: ["violations"] }));
  return violations.map(
    ({ id, nodes }) => `${id}: ${nodes.map((node) => `${node.target} ${node.failureSummary}`).join("; ")}`,
  );
}

export function looks(test, { browser, station, shots }) {
  for (const colorScheme of ["light", "dark"]) {
    test(`every route in ${colorScheme}: fits, and axe finds nothing`, async () => {
      for (const [size, [width, height]] of Object.entries(SIZES)) {
        const page = await browser.connected(station.url, {
          colorScheme,
          viewport: { width, height },
          bypassCSP: true,
        });
        const inControl = size === "desktop" || size === "phone";
        if (inControl) {
          await page.getByTestId("lease-take").click();
          await waitForState(page, "lease", "mine");
        }
        await page.locator("[data-testid=view][data-camera]").waitFor();
        for (const route of ROUTES) {
          await page.goto(`${station.url}#/${route}`);
          await waitForState(page, "route", route);
          if (["move", "world"].includes(route)) await page.locator("[data-testid=view][data-camera]").waitFor();
          await sleep(400);
          const over = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
          assert.ok(over <= 0, `${route} ${size}: ${over} px too wide`);
          if (size !== "at-200") await page.screenshot({ path: join(shots, `${route}-${colorScheme}-${size}.png`) });
          assert.deepEqual(await findings(page), [], `${route} ${size}`);
        }
        await page.getByTestId("help").click();
        await page.getByTestId("help-page").locator("h1").waitFor();
        assert.deepEqual(await findings(page), [], `help ${size}`);
        await page.getByTestId("tour").click();
        await page.getByTestId("tour-card").waitFor();
        assert.deepEqual(await findings(page), [], `tour ${size}`);
        await page.getByTestId("tour-end").click();
        if (inControl) {
          await page.getByTestId("lease-release").click();
          await waitForState(page, "lease", "free");
        }
        await page.context().close();
      }
    });
  }

  test("no route opened by its address shows an error before it is connected", async () => {
    for (const route of ROUTES) {
      const page = await browser.page(`${station.url}#/${route}`);
      await waitForState(page, "link", "up");
      await sleep(300);
      assert.equal(await page.getByTestId("notice").textContent(), "", route);
      // All images are loaded.
      const images = page.locator("main img");
      for (const image of await images.all()) {
        await image.scrollIntoViewIfNeeded();
        await image.evaluate((image) => image.decode());
      }
      await page.context().close();
    }
  });

  test("the picture of the guide", async () => {
    const page = await browser.inControl(station.url, { viewport: { width: 1280, height: 800 } });
    if ((await page.evaluate(() => document.body.dataset.alarm)) === "true")
      await page.getByTestId("clear-alarms").click();
    await waitForState(page, "alarm", "false");
    for (const [button, ms] of [
      ["z-plus", 900],
      ["y-plus", 1600],
      ["x-minus", 900],
      ["z-minus", 700],
    ]) {
      await page.getByTestId(`jog-${button}`).hover();
      await page.mouse.down();
      await sleep(ms);
      await page.mouse.up();
      await waitForState(page, "jog", "idle");
    }
    // State in the middle of a task. On a busy machine the jog may end before the screenshot, so it
    // is tried again.
    for (let tries = 0, runs = false; tries < 8 && !runs; tries++) {
      await page.getByTestId(tries % 2 === 0 ? "jog-y-minus" : "jog-y-plus").hover();
      await page.mouse.down();
      await sleep(500);
      await page.screenshot({ path: join(shots, "studio.png") });
      runs = await page.evaluate(() => document.body.dataset.jog === "running");
      await page.mouse.up();
      await waitForState(page, "jog", "idle");
    }
    await page.getByTestId("lease-release").click();
    await waitForState(page, "lease", "free");
    await page.context().close();
  });

  test("Chinese is complete, fits, and passes axe", async () => {
    const page = await browser.connected(station.url, { viewport: { width: 360, height: 740 }, bypassCSP: true });
    await page.goto(`${station.url}#/settings`);
    await page.getByTestId("settings-language-zh").check({ force: true });
    await page.locator("html[lang=zh-Hans]").waitFor();
    assert.equal(await page.getByTestId("stop").textContent(), "停止");
    assert.match(await page.locator("main").textContent(), /母语/);
    for (const route of ROUTES) {
      await page.goto(`${station.url}#/${route}`);
      await waitForState(page, "route", route);
      await sleep(300);
      const over = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
      assert.ok(over <= 0, `${route}: ${over} px too wide`);
      await page.screenshot({ path: join(shots, `${route}-zh.png`) });
      assert.deepEqual(await findings(page), [], route);
    }
    // Texts from the arm's table are translated too, except names of connectors and units.
    await page.goto(`${station.url}#/io`);
    await page.locator("form.device").first().waitFor();
    const said = await page
      .locator(".io")
      .evaluate((panel) => panel.innerText + [...panel.querySelectorAll("option")].map(({ text }) => text).join());
    assert.deepEqual(said.match(/[A-Za-z]{3,}/g), null);
    await page.context().close();
  });
}
