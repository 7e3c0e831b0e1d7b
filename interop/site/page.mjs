#!/usr/bin/env node
// Opens pages of a hub and measures them, for the script `page` beside this file: page.mjs URL PIN
// [--pictures] [--built DIR]. Each line of JSON on stdin is a command, answered by one line on
// stdout: {"open": N, "arms": M} opens pages until there are N, each of which shows M arms;
// {"measure": SECONDS}; {"stop": true} presses Stop all.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";
import { createInterface } from "node:readline";

const { chromium } = createRequire(new URL("../../studio/package.json", import.meta.url))("playwright-core");
const [url, pin] = process.argv.slice(2);
const pictures = process.argv.includes("--pictures");
const builtDir = process.argv.includes("--built") ? process.argv[process.argv.indexOf("--built") + 1] : null;
const graphicsFlags = pictures ? ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"] : ["--disable-3d-apis"];
// Browsers throttle pages in the background, but each of these represents one on its own screen.
const foregroundFlags = ["--disable-backgrounding-occluded-windows", "--disable-renderer-backgrounding", "--disable-background-timer-throttling"];
const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: ["--no-sandbox", ...graphicsFlags, ...foregroundFlags] });
const pages = [];

async function open(arms) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 860 } });
  const page = await context.newPage();
  // Serves the scripts of DIR with the hub's own headers, because these contain the content
  // security policy.
  if (builtDir !== null) await page.route(/assets.(?!worker)\w+\.js$/, async (route) => {
    const response = await route.fetch();
    const { "content-encoding": _, "content-length": __, ...headers } = response.headers();
    await route.fulfill({ status: 200, headers, body: readFileSync(join(builtDir, new URL(route.request().url()).pathname)) });
  });
  await page.addInitScript(() => localStorage.setItem("magician.name", "Ms Lee"));
  await page.goto(`${url}#/class`);
  // At a hub the form is open, since only teachers sign in there.
  await page.getByTestId("class-teacher").waitFor();
  if (!(await page.getByTestId("class-pin").isVisible())) await page.getByTestId("class-teacher").click();
  await page.getByTestId("class-pin").fill(pin);
  await page.getByTestId("class-pin-signin").click();
  // Arms without a state after this time count as silent.
  const allShown = page.waitForFunction((arms) => document.querySelectorAll(".tile[data-t]").length === arms, arms, { timeout: 30_000, polling: 500 });
  await allShown.catch(() => {});
  // Scrolls to the part of the page that a teacher looks at.
  await page.getByTestId("stop-all").evaluate((button) => button.scrollIntoView({ block: "start" }));
  const metrics = await context.newCDPSession(page);
  await metrics.send("Performance.enable");
  pages.push({ page, metrics });
}

/** Ages of the states shown by the tiles, s: of those in view and of the others. */
const ages = (page, seconds) => page.evaluate(async (seconds) => {
  const inView = new Set();
  const observer = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) isIntersecting ? inView.add(target) : inView.delete(target);
  });
  const tiles = [...document.querySelectorAll(".tile")];
  for (const tile of tiles) observer.observe(tile);
  await new Promise((done) => setTimeout(done, 500));
  const found = { tiles: inView.size, seen: [], others: [], silent: 0 };
  const ends = performance.now() + 1000 * seconds;
  while (performance.now() < ends) {
    const now = Date.now() / 1000;
    for (const tile of tiles) {
      const at = Number(tile.dataset.t);
      if (at > 0) (inView.has(tile) ? found.seen : found.others).push(now - at);
      else found.silent += 1;
    }
    await new Promise((done) => setTimeout(done, 250));
  }
  observer.disconnect();
  return found;
}, seconds);

const metricsByName = async (metrics) => Object.fromEntries((await metrics.send("Performance.getMetrics")).metrics.map(({ name, value }) => [name, value]));

function percentiles(values) {
  values.sort((one, two) => one - two);
  const at = (part) => (values.length > 0 ? Math.round(1000 * values[Math.round((values.length - 1) * part)]) / 1000 : null);
  return { p50: at(0.5), p99: at(0.99), max: at(1) };
}

/** Memory (PSS) of the largest process that renders a page, bytes. */
async function memory() {
  const session = await browser.newBrowserCDPSession();
  const { processInfo } = await session.send("SystemInfo.getProcessInfo");
  await session.detach();
  const sizes = processInfo.filter(({ type }) => type === "renderer").map(({ id }) => {
    const rollup = readFileSync(`/proc/${id}/smaps_rollup`, "utf8");
    return 1024 * Number(/^Pss:\s+(\d+)/m.exec(rollup)[1]);
  });
  return Math.max(...sizes);
}

const commands = {
  async open({ open: number, arms }) {
    while (pages.length < number) await open(arms);
    return pages.length;
  },
  async measure({ measure: seconds }) {
    const before = await Promise.all(pages.map(({ metrics }) => metricsByName(metrics)));
    const found = await Promise.all(pages.map(({ page }) => ages(page, seconds)));
    const after = await Promise.all(pages.map(({ metrics }) => metricsByName(metrics)));
    const busy = after.map((one, nth) => (one.TaskDuration - before[nth].TaskDuration) / (one.Timestamp - before[nth].Timestamp));
    return {
      in_view: { tiles: found[0].tiles, ...percentiles(found.flatMap(({ seen }) => seen)) },
      others: percentiles(found.flatMap(({ others }) => others)),
      each_page: found.map(({ seen }) => percentiles([...seen])),
      silent: found.reduce((sum, { silent }) => sum + silent, 0),
      busy: Math.max(...busy),
      heap: Math.max(...after.map(({ JSHeapUsedSize }) => JSHeapUsedSize)),
      memory: await memory(),
    };
  },
  async stop() {
    const [{ page }] = pages;
    const { x, y, width, height } = await page.getByTestId("stop-all").boundingBox();
    await page.mouse.move(x + width / 2, y + height / 2);
    const pressed = Date.now() / 1000;
    await page.mouse.down();
    await page.mouse.up();
    await page.waitForTimeout(4000);
    return { pressed };
  },
};

try {
  for await (const line of createInterface({ input: process.stdin })) {
    const command = JSON.parse(line);
    const [name] = Object.keys(command);
    const answer = await commands[name](command).catch((error) => ({ error: String(error) }));
    process.stdout.write(`${JSON.stringify(answer)}\n`);
  }
} finally {
  await browser.close();
}
