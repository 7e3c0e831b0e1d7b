// Tests of the studio in a browser, checked at the station: node e2e/suite.mjs [PART of the names]
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { setTimeout as sleep } from "node:timers/promises";
import { fileURLToPath } from "node:url";
import { app } from "./app.mjs";
import { classes } from "./arms.mjs";
import { Browser, near, Station, waitForState } from "./bench.mjs";
import { client } from "./client.mjs";
import { drawing } from "./draw.mjs";
import { galleryAtStation } from "./gallery.mjs";
import { lesson } from "./lesson.mjs";
import { looks } from "./looks.mjs";
import { refusals } from "./refusals.mjs";
import { running } from "./run.mjs";
import { onSerial } from "./serial.mjs";
import { onSim } from "./sim.mjs";
import { strips } from "./strip.mjs";
import { tasks } from "./tasks.mjs";
import { teaching } from "./teach.mjs";
import { views } from "./view.mjs";
import { walkthroughs } from "./walkthroughs.mjs";
import { worlds } from "./world.mjs";

const here = dirname(fileURLToPath(import.meta.url));
const program = process.env.MAGICIAN ?? join(here, "../../target/debug/magician");
assert.ok(existsSync(program), `${program} is not built`);
export const shots = join(here, "shots");
mkdirSync(shots, { recursive: true });

let station = new Station(program);
let browser = new Browser();
const first = { station, browser };
const tests = [];
const test = (name, body) => tests.push([name, body]);
let url = () => station.url;
/** Closes a page and releases its control for the next test. */
async function closePage(page) {
  const back = page.getByTestId("lease-release");
  if (station !== first.station) return page.context().close();
  if (await back.isVisible()) {
    await back.click();
    await waitForState(page, "lease", "free");
  }
  await page.context().close();
}

test("connects by itself and shows the pose", async () => {
  const page = await browser.connected(url());
  await waitForState(page, "backend", "station");
  await waitForState(page, "route", "move");
  const state = await station.pose();
  for (const name of ["x", "y", "z", "r", "j1", "j2", "j3", "j4"]) {
    const text = await page.getByTestId(`pose-${name}`).textContent();
    assert.match(text, /^-?\d+\.\d\d$/);
    assert.ok(near(Number(text), state[name]), `${name}: ${text} and ${state[name]}`);
  }
  assert.equal(await page.getByTestId("header-arm").textContent(), "Virtual arm");
  await page.keyboard.press("Tab");
  assert.equal(await page.evaluate(() => document.activeElement.dataset.testid), "stop");
  const { width, height } = await page.getByTestId("stop").boundingBox();
  assert.ok(width >= 44 && height >= 44);
  await closePage(page);
});

test("a disabled control states its reason", async () => {
  const page = await browser.connected(url());
  const button = page.getByRole("button", { name: "Jog X plus" });
  assert.ok(await button.isDisabled());
  const why = await button.getAttribute("aria-describedby");
  assert.match(await page.locator(`#${why}`).textContent(), /Take control/);
  await page.getByRole("button", { name: "Take control" }).click();
  await waitForState(page, "lease", "mine");
  assert.ok((await station.pose()).holder !== null);
  assert.ok(await button.isEnabled());
  await page.getByTestId("lease-release").click();
  await waitForState(page, "lease", "free");
  assert.equal((await station.pose()).holder, null);
  await closePage(page);
});

test("the power-on alarm shows the next step and is cleared", async () => {
  const page = await browser.inControl(url());
  await waitForState(page, "alarm", "true");
  const { alarms } = await station.call("arm.alarms");
  const text = await page.getByTestId(`alarm-${alarms[0].code}`).textContent();
  // The alarm after power-up is not a fault: it is explained in words, with the next step.
  assert.equal(alarms[0].code, 0);
  assert.match(text, /The arm was switched on\. Home it/);
  assert.ok(await page.getByTestId("alarm-home").isEnabled());
  await page.getByTestId("clear-alarms").click();
  await waitForState(page, "alarm", "false");
  assert.deepEqual((await station.pose()).alarms, []);
  await closePage(page);
});

test("a held button moves the arm until it is released", async () => {
  const page = await browser.inControl(url());
  let why = null;
  // On a busy machine the page may be too late to keep the jog alive, and it ends.
  for (let tries = 0; tries < 10 && why !== "released"; tries++) {
    const before = await station.waitForRest();
    await page.getByTestId("jog-z-plus").hover();
    await page.mouse.down();
    await waitForState(page, "jog", "running");
    await station.until("rises", (state) => state.z > before.z + 5 || state.jog === null);
    await page.mouse.up();
    await waitForState(page, "jog", "idle");
    const after = await station.waitForRest();
    assert.ok(after.z > before.z && near(after.x, before.x) && near(after.y, before.y));
    why = (await station.events()).filter((event) => event.event === "jog").at(-1).why;
  }
  assert.equal(why, "released");
  await closePage(page);
});

test("the browser's menu, a cancelled touch and a hidden page end a jog", async () => {
  const page = await browser.inControl(url());
  for (const end of ["contextmenu", "pointercancel", "blur", "hidden", "route"]) {
    await page.getByTestId("jog-y-plus").hover();
    await page.mouse.down();
    await waitForState(page, "jog", "running");
    await station.until("moves", (state) => state.moving);
    await page.evaluate((end) => {
      const button = document.querySelector("[data-testid=jog-y-plus]");
      if (end === "contextmenu")
        button.dispatchEvent(new MouseEvent("contextmenu", { bubbles: true, cancelable: true }));
      if (end === "pointercancel") button.dispatchEvent(new PointerEvent("pointercancel", { bubbles: true }));
      if (end === "blur") dispatchEvent(new Event("blur"));
      if (end === "route") location.hash = "#/arms";
      if (end === "hidden") {
        Object.defineProperty(document, "hidden", { configurable: true, get: () => true });
        document.dispatchEvent(new Event("visibilitychange"));
        delete document.hidden;
      }
    }, end);
    await waitForState(page, "jog", "idle");
    await station.waitForRest();
    await page.mouse.up();
  }
  await closePage(page);
});

test("keys jog, and losing the focus stops the jog", async () => {
  const page = await browser.inControl(url());
  const before = await station.waitForRest();
  await page.getByTestId("jog-pad").focus();
  await page.keyboard.down("ArrowDown");
  await waitForState(page, "jog", "running");
  await station.until("goes back", (state) => state.x < before.x - 4);
  await page.keyboard.up("ArrowDown");
  await waitForState(page, "jog", "idle");
  const middle = await station.waitForRest();
  await page.keyboard.down("ArrowUp");
  await waitForState(page, "jog", "running");
  await station.until("goes on", (state) => state.x > middle.x + 0.5);
  await page.getByTestId("settings-name").or(page.getByTestId("jog-speed")).first().focus();
  await waitForState(page, "jog", "idle");
  await station.waitForRest();
  await page.keyboard.up("ArrowUp");
  await closePage(page);
});

test("Escape and Space stop, and a key still held has no further effect", async () => {
  const page = await browser.inControl(url());
  await page.getByTestId("jog-pad").focus();
  for (const key of ["Escape", " "]) {
    await page.keyboard.down("w");
    await waitForState(page, "jog", "running");
    await station.until("moves", (state) => state.moving);
    await page.keyboard.press(key);
    await waitForState(page, "jog", "idle");
    const stood = await station.waitForRest();
    await page.keyboard.down("w");
    await sleep(300);
    assert.equal((await station.pose()).z, stood.z);
    await page.keyboard.up("w");
    await page.keyboard.down("s");
    await waitForState(page, "jog", "running");
    await page.keyboard.up("s");
    await waitForState(page, "jog", "idle");
  }
  await closePage(page);
});

test("a press makes one step: by button, by key, in the tool frame", async () => {
  const page = await browser.inControl(url());
  await page.getByTestId("jog-mode-step").check({ force: true });
  await page.getByTestId("jog-step-size").selectOption("10");
  let before = await station.waitForRest();
  await page.getByTestId("jog-x-minus").click();
  await station.until("10 mm back", (state) => near(state.x, before.x - 10) && !state.moving);
  await page.getByTestId("jog-pad").focus();
  await page.keyboard.press("-");
  assert.equal(await page.getByTestId("jog-step-size").inputValue(), "5");
  before = await station.waitForRest();
  await page.keyboard.press("ArrowLeft");
  await station.until("5 mm to the left", (state) => near(state.y, before.y + 5) && !state.moving);
  await page.getByTestId("jog-frame-joint").check({ force: true });
  before = await station.waitForRest();
  await page.getByTestId("jog-pad").focus();
  await page.keyboard.press("a");
  await station.until("J4 by 5", (state) => near(state.j4, before.j4 + 5) && !state.moving);
  await page.getByTestId("jog-frame-tool").check({ force: true });
  assert.ok(await page.getByTestId("jog-mode-hold").isDisabled());
  before = await station.waitForRest();
  await page.getByTestId("jog-x-plus").click();
  await station.until(
    "5 mm ahead",
    (state) => !state.moving && near(Math.hypot(state.x - before.x, state.y - before.y), 5, 0.05),
  );
  await closePage(page);
});

test("Stop stops the motion", async () => {
  const page = await browser.inControl(url());
  await station.waitForRest();
  await page.getByTestId("home").click();
  if (station.asks) await page.getByTestId("confirm-yes").click();
  await waitForState(page, "moving", "true");
  await page.getByTestId("stop").click();
  await waitForState(page, "moving", "false");
  await station.waitForRest();
  assert.ok((await station.events()).some((event) => event.event === "stop" && event.by !== null));
  await closePage(page);
});

test("homes", async () => {
  const page = await browser.inControl(url());
  await page.getByTestId("home").click();
  await waitForState(page, "moving", "true");
  await waitForState(page, "moving", "false", 40_000);
  await station.waitForRest();
  await closePage(page);
});

test("tools and speed reach the arm", async () => {
  const page = await browser.inControl(url());
  await page.getByRole("switch", { name: "Suction" }).click();
  await station.until("sucks", (state) => state.tool.suction === true);
  await page.getByTestId("tool-gripper-closed").click();
  await station.until("grips", (state) => state.tool.gripper === "closed");
  await page.getByTestId("tool-gripper-off").click();
  await page.getByTestId("tool-select").selectOption("pen");
  await station.until("has a pen", (state) => state.tool.name === "pen");
  await page.getByTestId("tool-select").selectOption("laser");
  await station.until("has a laser", (state) => state.tool.name === "laser");
  await page.getByTestId("tool-laser").click();
  await page.getByTestId("header-laser").waitFor();
  await page.getByTestId("tool-laser").click();
  await page.getByTestId("header-laser").waitFor({ state: "detached" });
  await page.getByTestId("tool-select").selectOption("suction");
  await page.getByTestId("arm-speed").fill("80");
  await station.until("is faster", (state) => state.speed === 80);
  await closePage(page);
});

test("the picture shows the tip at the projection of its pose", async () => {
  const page = await browser.connected(url());
  for (const view of ["corner", "front", "side", "top"]) {
    await page.getByTestId(`view-${view}`).click();
    await page.locator("[data-testid=view][data-camera]").waitFor();
    await sleep(700);
    const { x, y, z } = await station.pose();
    const { camera, tip, box } = await page.getByTestId("view").evaluate((view) => ({
      camera: view.dataset.camera.split(",").map(Number),
      tip: view.dataset.tip.split(",").map(Number),
      box: [view.clientWidth, view.clientHeight],
    }));
    const row = (at) => camera[at] * x + camera[at + 4] * y + camera[at + 8] * z + camera[at + 12];
    const at = [((row(0) / row(3) + 1) / 2) * box[0], ((1 - row(1) / row(3)) / 2) * box[1]];
    assert.ok(near(at[0], tip[0], 1.5) && near(at[1], tip[1], 1.5), `${view}: ${at} and ${tip}`);
  }
  await closePage(page);
});

test("without WebGL the arm is seen from above", async () => {
  const init = () => {
    HTMLCanvasElement.prototype.getContext = () => null;
  };
  const page = await browser.connected(url(), { init });
  await page.locator(".plan .reach[d^=M]").waitFor();
  assert.match(await page.getByTestId("view").getAttribute("data-tip"), /^[\d.]+,[\d.]+$/);
  await closePage(page);
});

test("without a graphics chip the picture has fewer pixels, and follows the arm", async () => {
  const sharpness = async (processor) => {
    const page = await browser.inControl(url(), { processor });
    const view = page.getByTestId("view");
    await page.locator("[data-testid=view][data-tip]").waitFor();
    const share = await view.locator("canvas").evaluate((canvas) => canvas.width / canvas.clientWidth);
    const before = await view.getAttribute("data-tip");
    await page.getByTestId("jog-y-plus").hover();
    await page.mouse.down();
    await page.waitForFunction((before) => document.querySelector("[data-testid=view]").dataset.tip !== before, before);
    await page.mouse.up();
    await waitForState(page, "jog", "idle");
    await closePage(page);
    return share;
  };
  assert.ok(near(await sharpness(true), 0.5));
  assert.ok(near(await sharpness(false), 1));
});

test("a second page requests and gets control, and a teacher takes it back", async () => {
  const one = await browser.inControl(url());
  const two = await browser.connected(url());
  await two.goto(`${url()}#/settings`);
  await two.getByTestId("settings-name").fill("Ada");
  await two.getByTestId("settings-name").press("Tab");
  await two.goto(`${url()}#/move`);
  await waitForState(two, "lease", "other");
  await one.getByTestId("jog-mode-step").check({ force: true });
  const { z: low } = await station.waitForRest();
  await one.getByTestId("jog-z-plus").click();
  const { z } = await station.until("a step up", (state) => state.z > low + 1 && !state.moving);
  await two.waitForFunction(
    (z) => Math.abs(Number(document.querySelector("[data-testid=pose-z]").textContent) - z) < 0.02,
    z,
  );
  await two.getByTestId("lease-ask").click();
  await one.getByRole("alertdialog", { name: "Ada asks for control" }).waitFor();
  await one.getByTestId("lease-refuse").click();
  await two.getByTestId("lease-ask").click();
  await one.getByTestId("lease-grant").click();
  await waitForState(two, "lease", "mine");
  await waitForState(one, "lease", "other");
  assert.match(await one.getByTestId("lease-holder").textContent(), /Ada/);
  await one.getByTestId("lease-take").click();
  await one.getByTestId("confirm-yes").click();
  await waitForState(one, "lease", "mine");
  await waitForState(two, "lease", "other");
  await closePage(two);
  await closePage(one);
});

test("a reload keeps control", async () => {
  const page = await browser.inControl(url());
  const { holder } = await station.pose();
  await page.reload();
  await waitForState(page, "lease", "mine");
  assert.equal((await station.pose()).holder.session, holder.session);
  await closePage(page);
});

test("closing a page ends its jog", async () => {
  const page = await browser.inControl(url());
  await page.getByTestId("jog-r-plus").hover();
  await page.mouse.down();
  await waitForState(page, "jog", "running");
  await station.until("moves", (state) => state.moving);
  await page.close();
  await station.waitForRest();
  await station.until("is free", (state) => state.holder === null, 8000);
});

test("a hanging page ends its jog", async () => {
  const page = await browser.inControl(url());
  await page.getByTestId("jog-r-minus").hover();
  await page.mouse.down();
  await waitForState(page, "jog", "running");
  const hung = page.evaluate(() => {
    for (const ends = performance.now() + 3000; performance.now() < ends; );
  });
  await station.until("stands while the page hangs", (state) => !state.moving && state.jog === null, 2000);
  await hung;
  await page.mouse.up();
  await waitForState(page, "jog", "idle");
  await closePage(page);
});

test("a lost station is reported and reconnected", async () => {
  const page = await browser.inControl(url());
  await station.kill();
  await waitForState(page, "link", "lost");
  await page.getByTestId("link-since").waitFor();
  assert.ok(await page.getByTestId("jog-x-plus").isDisabled());
  assert.ok(await page.getByTestId("stop").isEnabled());
  await waitForState(page, "stale", "true");
  await page.getByTestId("stop").click();
  await page.getByTestId("notice").getByText("did not reach").waitFor();
  await station.start();
  await waitForState(page, "link", "up", 10_000);
  await page.getByTestId("link-since").waitFor({ state: "detached" });
  await waitForState(page, "stale", "false");
  await closePage(page);
});

test("without a station the page says so, and connects to a typed address", async () => {
  const page = await browser.connected(url());
  await page.goto(`${url()}#/arms`);
  await page.getByRole("button", { name: "Disconnect" }).click();
  await waitForState(page, "backend", "none");
  await waitForState(page, "link", "closed");
  assert.ok(await page.getByTestId("connect-sim").isEnabled());
  assert.ok(await page.getByTestId("connect-serial").isEnabled());
  await page.getByTestId("station-url").fill("not:an:address");
  await page.getByTestId("connect-station").click();
  await page.getByText("Not a valid address").waitFor();
  await page.getByTestId("station-url").fill(new URL(url()).host);
  await page.getByTestId("station-token").fill("wrong");
  await page.getByTestId("connect-station").click();
  await page.getByText("needs a valid token").waitFor();
  await page.getByTestId("station-token").fill("");
  await page.getByTestId("connect-station").click();
  await waitForState(page, "link", "up");
  assert.match(await page.getByTestId("log").textContent(), /connected to/);
  await closePage(page);
});

test("Tab reaches every control and is never trapped", async () => {
  for (const route of ["move", "teach", "run", "io", "plots", "world", "arms", "settings"]) {
    const page = await browser.inControl(`${url()}#/${route}`);
    await page.evaluate(() => document.activeElement?.blur());
    const seen = new Set();
    let first = null;
    for (let press = 0; press < 130; press++) {
      await page.keyboard.press("Tab");
      const at = await page.evaluate(() => {
        const now = document.activeElement;
        return now === document.body ? "" : (now.dataset.testid ?? now.textContent);
      });
      if (at === first) break;
      if (at === "") continue;
      first ??= at;
      seen.add(at);
    }
    const wanted = {
      move: ["stop", "lease-release", "view", "jog-pad", "jog-x-plus", "home", "tool-suction"],
      teach: ["teach-add", "teach-open-button", "jog-pad"],
      draw: ["draw-text", "draw-open-button"],
      engrave: ["draw-text", "laser-testgrid"],
      run: ["program-open-button"],
      io: ["pin-1-function", "pin-20-function"],
      plots: ["plot-pause", "plot-scrub"],
      world: ["world-scenario", "world-scenario-open-button", "world-unlock", "world-reset"],
      arms: ["station-url", "log"],
      settings: ["settings-name"],
    };
    for (const name of wanted[route]) assert.ok(seen.has(name), `${route}: ${name} of ${[...seen]}`);
    await closePage(page);
  }
});

app(test, { browser, program });
worlds(test, { browser, station, shots, closePage });
views(test, { browser, station, shots, closePage });
galleryAtStation(test, { browser, station });
classes(test, { browser, program, shots });
lesson(test, { browser, program, shots });
running(test, { browser, station, closePage, shots });
strips(test, { browser, station, closePage });
teaching(test, { browser, station, closePage, shots });
refusals(test, { browser, url, closePage, shots });
drawing(test, { station, browser, url, closePage, shots, outlives: true });
walkthroughs(test, { browser, program, shots });
tasks(test, { browser, station, closePage });
looks(test, { browser, station, shots });
client(test, { browser, program });

const swap = (to) => ({ station, browser, url } = to);
const shared = [...tests];
/** Files of the page for a plain file server. */
const bundle = mkdtempSync(join(tmpdir(), "studio-"));
execFileSync(program, ["studio", "--export", bundle], { stdio: "ignore" });
const files = onSim(tests, { browser, swap, shots }, bundle);
const port = onSerial(tests, shared, { browser, swap, shots, program }, bundle);

test("no page logged an error", async () => assert.deepEqual(browser.complaints, []));

await station.start();
await browser.start();
let failed = 0;
for (const [name, body] of tests) {
  if (process.argv[2] && !name.includes(process.argv[2])) continue;
  const began = Date.now();
  try {
    await body();
    console.log(`ok    ${name} (${((Date.now() - began) / 1000).toFixed(1)} s)`);
  } catch (error) {
    failed++;
    console.log(`FAIL  ${name}\n${error.stack}`);
    // The next test has a new page.
    for (const context of browser.browser.contexts()) await context.close();
    if (station !== first.station) continue;
    if (!(await station.isRunning())) await station.start();
    await station.until("is free", (state) => state.holder === null, 8000);
  }
}
await first.browser.end();
files.end();
port.end();
await first.station.end();
rmSync(bundle, { recursive: true });
console.log(failed === 0 ? "all passed" : `${failed} failed`);
process.exitCode = failed === 0 ? 0 : 1;
