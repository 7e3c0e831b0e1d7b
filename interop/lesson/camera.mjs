#!/usr/bin/env node
// Takes a screenshot of the hub's arms at the size of a teacher's tablet: camera.mjs URL FILE
import { createRequire } from "node:module";

const { chromium } = createRequire(new URL("../../studio/package.json", import.meta.url))("playwright-core");
const [url, file] = process.argv.slice(2);
const executablePath = process.env.CHROMIUM ?? "/usr/bin/chromium";
const browser = await chromium.launch({ executablePath, args: ["--no-sandbox"] });
try {
  const page = await browser.newPage({ viewport: { width: 1024, height: 768 } });
  await page.addInitScript(() => localStorage.setItem("magician.name", "Ms Lee"));
  await page.goto(`${url}#/arms`);
  await page.locator("body[data-link=up]").waitFor({ timeout: 20_000 });
  // The states of all arms arrive within a second.
  await page.waitForTimeout(2500);
  await page.screenshot({ path: file });
} finally {
  await browser.close();
}
