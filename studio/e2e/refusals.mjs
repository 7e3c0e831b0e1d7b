// Messages of the station as shown by the page: options by their labels, and whole sentences in
// Chinese.
import assert from "node:assert/strict";
import { join } from "node:path";
import { waitForState } from "./bench.mjs";

/** Texts for the user must not contain names of the API. */
const API = /`|setup\.|\border: false|\bdespeckle\b|\bwork is\b|: true\b/;
const ENGLISH = /[a-z]{4,} [a-z]{2,}/;
/** Program with a line beyond the reach of any arm. */
const FAR = "G90\nG1 X900 Y0 Z0 F1000\nG1 X950 Y0 Z0\n";

export function refusals(test, { browser, url, closePage, shots }) {
  const far = (language) => ({ name: `far-${language}.gcode`, mimeType: "text/plain", buffer: Buffer.from(FAR) });
  for (const [language, wrong, refused] of [
    ["en", /“Capital height” is a number above 0/, /is out of reach; the nearest place in reach is/],
    ["zh", /“大写字母高度”应为大于 0/, /超出可达范围；最近的可达位置是/],
  ])
    test(`refusals are shown in the language of the page: ${language}`, async () => {
      const page = await browser.inControl(`${url()}#/draw`);
      await page.evaluate((name) => localStorage.setItem("magician.language", name), language);
      await page.reload();
      await waitForState(page, "route", "draw");
      await page.getByTestId("draw-text").fill("Mia");
      await page.getByTestId("setup-size").fill("-1");
      await page.getByTestId("setup-size").press("Tab");
      const problem = page.locator(".check.bad");
      await problem.getByText(wrong).waitFor();
      assert.doesNotMatch(await problem.textContent(), API);
      await page.screenshot({ path: join(shots, `said-draw-${language}.png`) });
      // After the correction the sheet is drawn.
      await page.getByTestId("setup-size").fill("");
      await page.getByTestId("setup-size").press("Tab");
      await page.locator(".check.good").waitFor();

      await page.goto(`${url()}#/run`);
      await waitForState(page, "route", "run");
      await page.getByTestId("program-open").setInputFiles(far(language));
      const complaint = page.getByTestId("run-complaint-1");
      await complaint.getByText(refused).waitFor();
      const text = await page.locator(".complaints").textContent();
      assert.doesNotMatch(text, API);
      if (language === "zh") assert.doesNotMatch(text, ENGLISH);
      await page.screenshot({ path: join(shots, `said-run-${language}.png`) });
      await page.evaluate(() => localStorage.removeItem("magician.language"));
      await closePage(page);
    });
}
