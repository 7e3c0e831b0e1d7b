// Measurements of the page, one per line: node e2e/figures.mjs [--json] [PART of the names].
// MAGICIAN is the program, a release build.
import { spawnSync } from "node:child_process";
import { createWriteStream, existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, statSync } from "node:fs";
import { createServer } from "node:http";
import { loadavg, tmpdir } from "node:os";
import { dirname, extname, join } from "node:path";
import { setTimeout as sleep } from "node:timers/promises";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";
import { Browser, Station, waitForState } from "./bench.mjs";
import { CuttableLink, now, RealArmStation } from "./line.mjs";
import { TYPES } from "./sim.mjs";

const root = join(dirname(fileURLToPath(import.meta.url)), "../..");
const program = process.env.MAGICIAN ?? join(root, "target/release/magician");
const json = process.argv.includes("--json");
const word = process.argv.slice(2).find((word) => !word.startsWith("--"));
const ROUTES = ["move", "teach", "run", "io", "plots", "world", "arms", "settings"];
const middle = (all) => all.toSorted((one, other) => one - other)[Math.floor(all.length / 2)];
const share = (all, part) =>
  all.toSorted((one, other) => one - other)[Math.min(all.length - 1, Math.floor(all.length * part))];
let failed = 0;

/** Prints a measurement with its limit: at most, or with `least` at least. */
function say(id, what, value, unit, most = null, least = null) {
  const good = (most === null || value <= most) && (least === null || value >= least);
  if (!good) failed++;
  const shown = Math.round(value * 100) / 100;
  const goal = most !== null ? `at most ${most}` : least !== null ? `at least ${least}` : "";
  if (json) console.log(JSON.stringify({ id, what, value: shown, unit, most, least, good }));
  else
    console.log(
      `${id}  ${what.padEnd(58)} ${String(shown).padStart(8)} ${unit.padEnd(4)} ${goal}${good ? "" : "  MISSED"}`,
    );
}

/** Runs a test with a browser and a station of its own. */
async function within(make, body) {
  const browser = new Browser();
  const station = make();
  await browser.start();
  await station.start();
  try {
    return await body(browser, station);
  } finally {
    await browser.end().catch(() => {});
    await station.end();
  }
}
const virtual = () => new Station(program);
const wired = () => new RealArmStation(program);
const ready = async (page) => {
  if ((await page.evaluate(() => document.body.dataset.alarm)) === "true")
    await page.getByTestId("clear-alarms").click();
  await waitForState(page, "alarm", "false");
};

/** Lighthouse, installed in a separate folder because it is not one of the page's packages. */
function lighthouse() {
  const folder = join(root, "target/lighthouse");
  const cli = join(folder, "node_modules/lighthouse/cli/index.js");
  if (!existsSync(cli)) {
    mkdirSync(folder, { recursive: true });
    spawnSync(
      "npm",
      ["install", "--prefix", folder, "--ignore-scripts", "--no-audit", "--no-fund", "--no-save", "lighthouse@12.8.2"],
      { stdio: "inherit" },
    );
  }
  return (url, categories, { dark = false, throttled = "simulate" } = {}) => {
    const out = join(folder, "report.json");
    const flags = `--headless=new --no-sandbox --use-gl=angle --use-angle=swiftshader --enable-unsafe-swiftshader --blink-settings=preferredColorScheme=${dark ? 0 : 1}`;
    const words = [
      cli,
      url,
      "--quiet",
      "--output=json",
      `--output-path=${out}`,
      `--only-categories=${categories}`,
      `--throttling-method=${throttled}`,
      `--chrome-flags=${flags}`,
    ];
    const ran = spawnSync("node", words, {
      env: { ...process.env, CHROME_PATH: process.env.CHROMIUM ?? "/usr/bin/chromium" },
      encoding: "utf8",
    });
    if (ran.status !== 0) throw new Error(ran.stderr);
    return JSON.parse(readFileSync(out, "utf8"));
  };
}

/**
 * File server behind a slow line: `rate` bytes a second for all requests together, and 20 ms in
 * each direction.
 */
async function slowly(folder, rate) {
  let [free, bytes] = [0, 0];
  const packed = new Map();
  const server = createServer(async (request, response) => {
    const path = join(folder, new URL(request.url, "http://page").pathname.replace(/\/$/, "/index.html"));
    if (!existsSync(path)) return response.writeHead(404).end();
    if (!packed.has(path)) packed.set(path, gzipSync(readFileSync(path), { level: 9 }));
    const body = packed.get(path);
    await sleep(40);
    response.writeHead(200, { "content-type": TYPES[extname(path)] ?? "text/plain", "content-encoding": "gzip" });
    for (let at = 0; at < body.length && request.method !== "HEAD"; at += PIECE) {
      const piece = body.subarray(at, at + PIECE);
      free = Math.max(free, now()) + (1000 * piece.length) / rate;
      bytes += piece.length;
      await sleep(free - now());
      response.write(piece);
    }
    response.end();
  });
  await new Promise((done) => server.listen(0, "127.0.0.1", done));
  return {
    url: `http://127.0.0.1:${server.address().port}/`,
    taken: () => [bytes, (bytes = 0)][0],
    end: () => {
      server.closeAllConnections();
      server.close();
    },
  };
}
const PIECE = 16 * 1024;

const figures = {
  async paint() {
    await within(virtual, async (browser, station) => {
      const look = lighthouse();
      // Throttled by the browser. The results that Lighthouse extrapolates from an unthrottled run
      // are not what a user waits for.
      for (const [throttled, most] of [
        ["devtools", 1000],
        ["simulate", null],
      ]) {
        const seen = [0, 1, 2].map(() => look(`${station.url}#/move`, "performance", { throttled }).audits);
        say(
          "W2",
          `first paint, Lighthouse mobile (${throttled}), middle of 3`,
          middle(seen.map((audits) => audits["first-contentful-paint"].numericValue)),
          "ms",
          most,
        );
      }
      // Stop must work before the picture and the module are loaded, so both are held back.
      const context = await browser.browser.newContext();
      const page = await context.newPage();
      let held = 0;
      await context.route(/three\.js|scene\.js|\.wasm/, () => void held++);
      await page.goto(station.url);
      await waitForState(page, "link", "up");
      const began = now();
      await page.getByTestId("stop").click();
      await page.getByTestId("notice").locator("p").waitFor();
      say("W2", "Stop answered while the picture is still held back", now() - began, "ms");
      say("W2", "files of the picture that were asked for and held back", held, "", null, 1);
      await context.close();
    });
  },

  /** Waiting time of a first visit to the page as static files, over a line of 10 Mbit/s. */
  async visit() {
    const folder = mkdtempSync(join(tmpdir(), "studio-visit-"));
    spawnSync(program, ["studio", "--export", folder], { stdio: "inherit" });
    const files = await slowly(folder, 10e6 / 8);
    const browser = new Browser();
    await browser.start();
    try {
      const waits = [];
      for (let nth = 0; nth < 3; nth++) {
        const context = await browser.browser.newContext({ viewport: { width: 1280, height: 860 } });
        const page = await context.newPage();
        const began = now();
        await page.goto(files.url);
        await page.getByTestId("connect-sim").click();
        await waitForState(page, "lease", "mine", 60_000);
        const pressed = now();
        await page.getByTestId("first-wave").click();
        await waitForState(page, "moving", "true", 60_000);
        waits.push({ all: now() - began, motion: now() - pressed, bytes: files.taken() });
        await context.close();
      }
      const of = (name) => middle(waits.map((wait) => wait[name]));
      say("W1", "first visit at 10 Mbit/s until the arm moves, middle of 3", of("all"), "ms", 5000);
      say("W1", "of that from the press of Wave", of("motion"), "ms");
      say("W1", "bytes that were fetched", of("bytes"), "B");
    } finally {
      await browser.end();
      files.end();
      rmSync(folder, { recursive: true, force: true });
    }
  },

  async lighthouse() {
    await within(virtual, async (_, station) => {
      const look = lighthouse();
      for (const dark of [false, true]) {
        for (const route of ROUTES) {
          const { categories, audits } = look(`${station.url}#/${route}`, "accessibility,best-practices", { dark });
          for (const { id, score, auditRefs } of Object.values(categories)) {
            say("W2", `Lighthouse ${id}, ${route}, ${dark ? "dark" : "light"}`, score * 100, "", null, 100);
            const wrong = auditRefs.filter(
              ({ id, weight }) => weight > 0 && audits[id].score !== null && audits[id].score < 1,
            );
            for (const { id } of wrong)
              console.error(`${id}: ${audits[id].title} ${JSON.stringify(audits[id].details?.items?.slice(0, 3))}`);
          }
        }
      }
    });
  },

  async latency() {
    for (const flat of [false, true])
      await within(virtual, async (browser, station) => {
        const init = (flat) => {
          if (flat) HTMLCanvasElement.prototype.getContext = () => null;
          [window.heard, window.spent] = [[], []];
          let read = null;
          window.Worker = class extends Worker {
            constructor(...given) {
              super(...given);
              this.addEventListener("message", ({ data }) => {
                const { state } = data.message?.params ?? {};
                if (state && ["x", "y", "z"].some((name) => name in state)) {
                  read = state.t;
                  window.heard.push(performance.timeOrigin + performance.now() - read * 1000);
                }
              });
            }
          };
          addEventListener("DOMContentLoaded", () => {
            const shown = new MutationObserver((changes) => {
              if (
                read === null ||
                !changes.some(
                  ({ target }) =>
                    target.parentElement?.closest?.("[data-testid^=pose-]") ?? target.closest?.("[data-testid^=pose-]"),
                )
              )
                return;
              const at = read;
              read = null;
              // The frame with the change has been rendered.
              requestAnimationFrame(() =>
                setTimeout(() => window.spent.push(performance.timeOrigin + performance.now() - at * 1000)),
              );
            });
            shown.observe(document.body, { subtree: true, childList: true, characterData: true });
          });
        };
        const page = await browser.inControl(station.url, { init: `(${init})(${flat})`, processor: true });
        await ready(page);
        await page.locator("[data-testid=view][data-tip]").waitFor();
        for (let turn = 0; turn < 8; turn++) {
          await page.getByTestId(`jog-${turn % 2 ? "y-minus" : "y-plus"}`).hover();
          await page.mouse.down();
          await sleep(1500);
          await page.mouse.up();
          await waitForState(page, "jog", "idle");
        }
        const { heard, spent } = await page.evaluate(() => ({ heard: window.heard, spent: window.spent }));
        say("W5", "pose read to heard by the page, p50", share(heard, 0.5), "ms");
        say(
          "W5",
          `pose read to shown, ${flat ? "from above" : "3D in software"}, p50 of ${spent.length}`,
          share(spent, 0.5),
          "ms",
          20,
        );
        say("W5", "the same, p99", share(spent, 0.99), "ms", 50);
      });
  },

  async cut() {
    const processes = async (browser) => {
      const session = await browser.browser.newBrowserCDPSession();
      const { processInfo } = await session.send("SystemInfo.getProcessInfo");
      return processInfo.filter(({ type }) => type === "renderer").map(({ id }) => id);
    };
    const ways = {
      "the button is let go": ({ page }) => page.mouse.up(),
      "the tab is closed": ({ page }) => page.close(),
      // A browser freezes only pages that were hidden before.
      "the tab is hidden": ({ page }) =>
        page.evaluate(() => {
          Object.defineProperty(document, "hidden", { configurable: true, get: () => true });
          document.dispatchEvent(new Event("visibilitychange"));
        }),
      "the page is paused by a debugger": ({ debug }) => debug.send("Debugger.pause"),
      "the tab's process stands still (SIGSTOP)": ({ stopped }) =>
        stopped.forEach((pid) => process.kill(pid, "SIGSTOP")),
      "the tab's process is killed": ({ stopped }) => stopped.forEach((pid) => process.kill(pid, "SIGKILL")),
      "the line is dropped": ({ way }) => way.drop(),
      "the line falls silent": ({ way }) => (way.isOpen = false),
    };
    for (const [name, deed] of Object.entries(ways)) {
      const took = [];
      let ended = 0;
      for (let round = 0; took.length < 5 && round < 15; round++) {
        const way = new CuttableLink();
        await way.start();
        await within(
          () => new RealArmStation(program, ["--allow-host", `127.0.0.1:${way.port}`]),
          async (browser, station) => {
            way.to = Number(new URL(station.url).port);
            const page = await browser.inControl(`http://127.0.0.1:${way.port}/`);
            await ready(page);
            await page.getByTestId("jog-z-plus").hover();
            await page.mouse.down();
            await waitForState(page, "jog", "running");
            await sleep(400);
            const stopped = await processes(browser);
            const debug = await page.context().newCDPSession(page);
            await debug.send("Debugger.enable");
            // On a busy machine the jog may have ended already.
            if ((await page.evaluate(() => document.body.dataset.jog)) !== "running") return void (ended += 1);
            const when = now();
            const done = deed({ page, way, stopped, debug });
            took.push(await station.line.stopAfter(when));
            for (const pid of stopped) if (name.includes("SIGSTOP")) process.kill(pid, "SIGCONT");
            await Promise.race([done, sleep(1000)]);
            way.drop();
          },
        );
      }
      say(
        "W6",
        `${name}: to the stop at the arm, longest of ${took.length}${ended ? ` (${ended} had ended)` : ""}`,
        Math.max(...took),
        "ms",
        300,
      );
    }
  },

  async day() {
    await within(virtual, async (browser, station) => {
      // States arrive as fast as the page accepts them, and its clock advances with them.
      const init = () => {
        window.ahead = 0;
        for (const clock of [performance, Date]) {
          const plain = clock.now.bind(clock);
          clock.now = () => plain() + window.ahead;
        }
        window.Worker = class extends Worker {
          constructor(...given) {
            super(...given);
            window.feed = (message) => this.onmessage({ data: { kind: "heard", message } });
            this.addEventListener("message", ({ data }) => {
              const { subscription, state } = data.message?.params ?? {};
              if (state?.arm !== undefined) window.first = { subscription, state };
            });
          }
        };
      };
      const page = await browser.connected(station.url, { init });
      await page.locator("[data-testid=view][data-camera]").waitFor();
      const session = await page.context().newCDPSession(page);
      const heap = async () => {
        for (let turn = 0; turn < 3; turn++) await session.send("HeapProfiler.collectGarbage");
        return (await session.send("Runtime.getHeapUsage")).usedSize / 1e6;
      };
      const lived = (seconds) =>
        page.evaluate(async (seconds) => {
          const { subscription, state } = window.first;
          const { arm } = state;
          window.nth ??= 0;
          for (let left = seconds * 20; left > 0; left--) {
            const nth = window.nth++;
            window.ahead += 50;
            const turn = nth / 40;
            const [x, y] = [220 + 60 * Math.cos(turn), 80 * Math.sin(turn)];
            window.feed({
              method: "arm.state",
              params: {
                arm,
                subscription,
                state: {
                  t: state.t + nth / 20,
                  x,
                  y,
                  j1: (Math.atan2(y, x) * 180) / Math.PI,
                  moving: true,
                  current_index: nth,
                },
              },
            });
            // An alarm, a change of control and a job every minute.
            if (nth % 1200 === 0) {
              window.feed({
                method: "arm.event",
                params: { arm, seq: nth, event: nth % 2400 ? "alarm-raised" : "alarm-cleared", code: 64 },
              });
              window.feed({
                method: "lease.changed",
                params: { arm, holder: nth % 2400 ? { session: `s${nth}`, name: "Ada" } : null },
              });
              window.feed({
                method: "job.changed",
                params: {
                  job: {
                    job: `j${nth}`,
                    arm,
                    title: "day",
                    state: "done",
                    step: 1,
                    steps: 1,
                    loop: 1,
                    loops: 1,
                    holder: null,
                  },
                },
              });
            }
            if (left % 400 === 0) await new Promise((done) => setTimeout(done));
          }
        }, seconds);
      for (const route of ["plots", "run", "arms", "move"]) {
        await page.goto(`${station.url}#/${route}`);
        await waitForState(page, "route", route);
        await lived(300);
      }
      const before = await heap();
      for (let hour = 0; hour < 8; hour++) await lived(3600);
      const after = await heap();
      say("W7", "heap after 8 h of 20 states a second, in the page's time", after, "MB");
      say("W7", "more than at the beginning", after - before, "MB", 10);
    });
  },

  async million() {
    await within(wired, async (browser, station) => {
      const path = join(station.state, "million.gcode");
      await new Promise((done) => {
        const to = createWriteStream(path).on("finish", done);
        to.write("G21\nG90\nG1 F3000 Z-50\n");
        for (let nth = 0; nth < 1000; nth++) {
          to.write(
            Array.from(
              { length: 1000 },
              (_, at) =>
                `X${(200 + ((nth + at) % 400) / 10).toFixed(3)} Y${((at % 250) / 10 + nth / 100).toFixed(3)}\n`,
            ).join(""),
          );
        }
        to.end();
      });
      const init = () => {
        window.longest = 0;
        // Time at which the press reached the browser.
        addEventListener("click", (event) => (window.pressed = performance.timeOrigin + event.timeStamp), true);
        new PerformanceObserver((list) =>
          list.getEntries().forEach(({ duration }) => (window.longest = Math.max(window.longest, duration))),
        ).observe({ entryTypes: ["longtask"] });
      };
      const page = await browser.inControl(station.url, { init });
      await ready(page);
      await page.goto(`${station.url}#/run`);
      await waitForState(page, "route", "run");
      await page.locator("[data-testid=view][data-camera]").waitFor();
      await sleep(2000);
      const longest = async (what, body) => {
        await page.evaluate(() => (window.longest = 0));
        const began = now();
        await body();
        const took = now() - began;
        await sleep(200);
        say("W8", `longest task of the page: ${what}`, await page.evaluate(() => window.longest), "ms", 100);
        return took;
      };
      const opened = await longest("opening it", async () => {
        await page.getByTestId("program-open").setInputFiles(path);
        await page.locator('[data-testid="program-million.gcode"][aria-selected=true]').waitFor({ timeout: 60_000 });
      });
      say("W8", `${(statSync(path).size / 1e6).toFixed(1)} MB opened`, opened, "ms");
      const shown = await longest("its path", async () => {
        await page.getByTestId("run-preview").click();
        await page.locator("[data-testid=run-preview][data-shown=true]").waitFor({ timeout: 60_000 });
      });
      say("W8", "its path is shown", shown, "ms", 3000);
      const stop = async (what) => {
        await page.getByTestId("stop").click();
        const when = await page.evaluate(() => window.pressed);
        const at = await station.line.stopAfter(when);
        await page.getByTestId("notice").locator("p").waitFor();
        say("W8", `Stop while it ${what}: at the arm`, at, "ms", 100);
        say("W8", `Stop while it ${what}: answered, the arm stands`, now() - when, "ms");
        await page.getByTestId("notice").locator("p").waitFor({ state: "detached" });
      };
      const started = async () => {
        await page.getByTestId("run-start").click();
        await page.getByTestId("confirm-yes").click();
      };
      await page.getByTestId("run-check").click();
      await sleep(300);
      await stop("is checked");
      await page.locator(".check.busy").waitFor({ state: "detached", timeout: 60_000 });
      await started();
      await waitForState(page, "job", "running", 60_000);
      await sleep(1500);
      await longest("while it runs", () => stop("runs"));
    });
  },
};

for (const [name, body] of Object.entries(figures)) {
  if (word !== undefined && !name.includes(word)) continue;
  const load = loadavg()[0].toFixed(1);
  if (!json) console.log(`${name}, load ${load}`);
  try {
    await body();
  } catch (error) {
    failed++;
    console.log(`FAIL ${name}\n${error.stack}`);
  }
}
process.exitCode = failed === 0 ? 0 : 1;
