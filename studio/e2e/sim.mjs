// Tests of the page as static files, with its station and virtual arm in the page's worker.
import assert from "node:assert/strict";
import { existsSync, readFileSync } from "node:fs";
import { createServer } from "node:http";
import { extname, join } from "node:path";
import { Browser, near, Station, waitForState } from "./bench.mjs";
import { drawing } from "./draw.mjs";
import { gallery } from "./gallery.mjs";

export const TYPES = {
  ".html": "text/html",
  ".js": "text/javascript",
  ".css": "text/css",
  ".svg": "image/svg+xml",
  ".json": "application/json",
  ".wasm": "application/wasm",
  ".png": "image/png",
  ".webp": "image/webp",
  ".webmanifest": "application/manifest+json",
};
/** URL path of the page: a subfolder, as where it is published with the book. */
const PAGE_PATH = "/book/studio/";
/** Tests of the station's page that apply here unchanged. */
export const SHARED_TESTS = [
  "a held button moves the arm until it is released",
  "the browser's menu, a cancelled touch and a hidden page end a jog",
  "keys jog, and losing the focus stops the jog",
  "Escape and Space stop, and a key still held has no further effect",
  "a press makes one step: by button, by key, in the tool frame",
  "Stop stops the motion",
  "the picture shows the tip at the projection of its pose",
  "a hanging page ends its jog",
];

/** Plain file server. `patch` changes its files, as a newer build does. */
export class Files {
  patched = new Map();

  constructor(folder) {
    this.folder = folder;
  }

  async start() {
    if (this.server?.listening) return;
    this.server = createServer((request, response) => {
      const { pathname } = new URL(request.url, "http://page");
      const name = pathname.startsWith(PAGE_PATH) ? pathname.slice(PAGE_PATH.length) || "index.html" : "../nowhere";
      const path = join(this.folder, name);
      if (!existsSync(path) || name.includes("..")) return response.writeHead(404).end();
      response.writeHead(200, { "content-type": TYPES[extname(path)] ?? "text/plain" });
      response.end(request.method === "HEAD" ? undefined : (this.patched.get(name) ?? readFileSync(path)));
    });
    await new Promise((done) => this.server.listen(this.port ?? 0, "127.0.0.1", done));
    this.port = this.server.address().port;
    this.url = `http://127.0.0.1:${this.port}${PAGE_PATH}`;
  }

  /** Simulates another build, with another service worker and another title. */
  renew() {
    const text = (name) => readFileSync(join(this.folder, name), "utf8");
    this.patched.set("sw.js", text("sw.js").replace(/BUILD = "/, 'BUILD = "newer'));
    this.patched.set("index.html", text("index.html").replace("<title>", "<title>Newer "));
  }

  end() {
    this.server?.closeAllConnections();
    this.server?.close();
  }
}

/** The arm in a page's worker, accessed directly by a session over a MessagePort. */
export class Sim extends Station {
  async join(page) {
    this.worker = page.workers()[0];
    await this.worker.evaluate(() => {
      const { port1, port2 } = new MessageChannel();
      globalThis.suite = { port: port2, ids: 0, waiting: new Map() };
      port2.onmessage = ({ data }) => globalThis.suite.waiting.get(data.id)?.(data);
      dispatchEvent(new MessageEvent("message", { data: { kind: "join" }, ports: [port1] }));
    });
    await this.call("session.hello", { client: { name: "suite" } });
  }

  async call(method, params = {}) {
    const { result, error } = await this.worker.evaluate(
      ([method, params]) =>
        new Promise((done) => {
          const { suite } = globalThis;
          const id = ++suite.ids;
          suite.waiting.set(id, done);
          suite.port.postMessage({ jsonrpc: "2.0", id, method, params });
        }),
      [method, params],
    );
    if (error) throw new Error(`${method}: ${error.message}`);
    return result;
  }
}

/** Pages that have opened the virtual arm. */
class SimBrowser extends Browser {
  constructor(other, sim) {
    super();
    this.other = other;
    this.complaints = other.complaints;
    this.sim = sim;
  }

  get browser() {
    return this.other.browser;
  }

  async inControl(url, options) {
    const page = await this.page(url, options);
    await page.getByTestId("connect-sim").click();
    await waitForState(page, "lease", "mine");
    await waitForState(page, "stale", "false");
    await this.sim.join(page);
    return page;
  }

  connected(url, options) {
    return this.inControl(url, options);
  }
}

/** Adds the tests shared with the station's page, and those only for static files. */
export function onSim(tests, bench, folder) {
  const files = new Files(folder);
  const sim = new Sim("none");
  const browser = new SimBrowser(bench.browser, sim);
  const test = (name, body) => {
    tests.push([
      name,
      async () => {
        await files.start();
        bench.swap({ station: sim, browser, url: () => files.url });
        await body();
      },
    ]);
  };
  const closePage = (page) => page.context().close();

  test("files: the arm of the page is homed, in control, and moves at the first press", async () => {
    const page = await browser.page(files.url);
    const began = Date.now();
    await waitForState(page, "backend", "none");
    assert.match(await page.getByTestId("connect-serial").getAttribute("aria-describedby"), /serial-why/);
    await page.getByRole("button", { name: "Virtual arm" }).click();
    await waitForState(page, "backend", "sim");
    await waitForState(page, "lease", "mine");
    await sim.join(page);
    const before = await sim.pose();
    assert.deepEqual(before.alarms, []);
    assert.notEqual(before.homed, false);
    assert.ok(before.holder !== null);
    await page.getByTestId("first-wave").click();
    await sim.until("waves", (state) => Math.abs(state.j1 - before.j1) > 5);
    assert.ok(Date.now() - began < 20_000, `${Date.now() - began} ms to the first motion`);
    // Screenshot for the guide.
    await page.screenshot({ path: join(bench.shots, "offline.png") });
    await page.getByTestId("stop").click();
    await waitForState(page, "moving", "false");
    await waitForState(page, "job", "stopped");
    assert.equal(await page.getByTestId("header-arm").textContent(), "Virtual arm");
    await closePage(page);
  });

  test("files: the house and a name are on the paper, and the speed is the address's", async () => {
    const page = await browser.inControl(`${files.url}?speed=20`);
    assert.equal(await page.getByTestId("header-arm").textContent(), "Virtual arm ×20");
    await page.getByTestId("first-house").click();
    await waitForState(page, "job", "done", 10_000);
    const { drawing, strokes } = await sim.call("world.look");
    // Upright for a reader in front of the arm: the ridge of the roof is nearest to the arm, in the
    // middle.
    const house = strokes.flatMap(({ points }) => points);
    const [tip] = house.toSorted(([one], [other]) => one - other);
    assert.ok(near(tip[0], 205, 0.5) && near(tip[1], 0, 0.5), `${tip}`);
    // Eight lines in one stroke.
    assert.ok((drawing.match(/<path|<polyline/g) ?? []).length > 1 || /d="M[^"]{40,}/.test(drawing), drawing);
    const before = drawing.length;
    await page.getByTestId("first-draw").click();
    await page.getByTestId("draw-text").fill("Ångström");
    await page.locator("[data-testid=draw-preview][data-shown=true]").waitFor();
    await page.getByTestId("draw-start").click();
    await waitForState(page, "job", "running", 20_000);
    await waitForState(page, "job", "done", 30_000);
    const written = (await sim.call("world.look")).drawing;
    assert.ok(written.length > before + 1000, `${before} and ${written.length} of drawing`);
    // The name has space beside the house.
    const name = (await sim.call("world.look")).strokes.slice(strokes.length).flatMap(({ points }) => points);
    assert.ok(name.length > 50 && name.every(([x, y]) => !(x > 205 && x < 292 && Math.abs(y) < 30)));
    await page.screenshot({ path: join(bench.shots, "name.png") });
    await page.goto(`${files.url}?speed=20#/move`);
    await page.getByTestId("first-close").click();
    await page.getByTestId("first-house").waitFor({ state: "detached" });
    await closePage(page);
  });

  test("files: a scenario homes its arm like the first start, and a stopped laser is not reported as on", async () => {
    const page = await browser.inControl(files.url);
    await page.goto(`${files.url}#/world`);
    await page.getByTestId("world-scenario").selectOption("engraving");
    await page.getByText("The arm restarted in the new world").waitFor();
    await sim.until("is homed", (state) => state.homed !== false && state.alarms.length === 0 && !state.moving);
    await waitForState(page, "alarm", "false");
    // Control and subscriptions are as before.
    await waitForState(page, "lease", "mine");
    await page.goto(`${files.url}#/move`);
    await page.getByTestId("tool-laser").click();
    await page.getByTestId("header-laser").waitFor();
    await page.getByTestId("stop").click();
    await page.getByTestId("header-laser").waitFor({ state: "detached" });
    assert.equal((await sim.pose()).tool.laser, false);
    // The same while a job burns.
    await page.goto(`${files.url}#/engrave`);
    await page.getByTestId("draw-text").fill("Laser");
    await page.getByText("The arm can do it").waitFor();
    await page.getByTestId("laser-arm").click();
    await page.getByTestId("draw-start").click();
    await page.getByTestId("header-laser").waitFor({ timeout: 30_000 });
    await page.getByTestId("stop").click();
    await waitForState(page, "job", "stopped");
    await page.getByTestId("header-laser").waitFor({ state: "detached" });
    await closePage(page);
  });

  test("files: a held jog does not run while the browser sleeps", async () => {
    const page = await browser.inControl(files.url);
    const devtools = await browser.browser.newBrowserCDPSession();
    await page.getByTestId("jog-y-plus").hover();
    await page.mouse.down();
    await waitForState(page, "jog", "running");
    await sim.until("moves", (state) => state.moving);
    const { processInfo } = await devtools.send("SystemInfo.getProcessInfo");
    const renderers = processInfo.filter(({ type }) => type === "renderer").map(({ id }) => id);
    const before = await sim.pose();
    for (const id of renderers) process.kill(id, "SIGSTOP");
    await new Promise((done) => setTimeout(done, 3000));
    for (const id of renderers) process.kill(id, "SIGCONT");
    const after = await sim.waitForRest();
    // The arm moves until the hanging page is detected, and then brakes. A jog that continued would
    // move for three more seconds.
    assert.ok(Math.abs(after.y - before.y) < 40, `${before.y} to ${after.y}`);
    await page.mouse.up();
    await devtools.detach();
    await closePage(page);
  });

  for (const [name, body] of [...tests]) {
    if (SHARED_TESTS.includes(name)) test(`files: ${name}`, body);
  }

  test("files: after a visit the page works offline: reload, move, and stored programs", async () => {
    const page = await browser.inControl(files.url);
    const text = JSON.stringify({ format: "magician-plan", version: 1, steps: [{ wait: 1 }] });
    await sim.call("lease.take", {});
    for (const name of ["one.plan.json", "two.plan.json"]) await sim.call("program.put", { name, text });
    await sim.call("program.delete", { name: "two.plan.json" });
    await page.evaluate(() => navigator.serviceWorker.ready);
    await page.waitForFunction(async () =>
      (await (await navigator.storage.getDirectory()).getDirectoryHandle("programs"))
        .getFileHandle("one.plan.json")
        .then((handle) => handle.getFile())
        .then(
          (file) => file.size > 0,
          () => false,
        ),
    );
    await page.context().setOffline(true);
    files.end();
    await page.reload();
    await waitForState(page, "ready", "true");
    await waitForState(page, "backend", "sim");
    await waitForState(page, "lease", "mine");
    await sim.join(page);
    const { programs } = await sim.call("program.list");
    assert.deepEqual(
      programs.map(({ name, bytes }) => [name, bytes]),
      [["one.plan.json", text.length]],
    );
    const before = await sim.waitForRest();
    await page.getByTestId("jog-mode-step").check({ force: true });
    await page.getByTestId("jog-z-plus").click();
    await sim.until("a step up", (state) => near(state.z, before.z + 5) && !state.moving);
    await closePage(page);
  });

  gallery(test, { browser, station: sim, url: () => files.url });

  drawing((name, body) => test(`files: ${name}`, body), {
    station: sim,
    browser,
    url: () => `${files.url}?speed=10`,
    closePage,
  });

  const sample = (name) => join(import.meta.dirname, "../../crates/magician-program/samples", name);
  const onRun = async (query = "") => {
    const page = await browser.inControl(files.url + query);
    await page.goto(`${files.url}${query}#/run`);
    await waitForState(page, "route", "run");
    return page;
  };
  const openFile = async (page, from) => {
    await page.getByTestId("program-open").setInputFiles(typeof from === "string" ? sample(from) : from);
    const name = typeof from === "string" ? from : from.name;
    await page.locator(`[data-testid="program-${name}"][aria-selected=true]`).waitFor();
  };
  const setOption = async (page, name, text) => {
    await page.getByTestId(`setup-${name}`).fill(text);
    await page.getByTestId(`setup-${name}`).press("Tab");
  };
  const waitForValidCheck = async (page) => {
    await page.getByText("The arm can do it").waitFor();
    await page.locator("[data-testid=run-preview][data-shown=true]").waitFor();
  };

  test("files: drawings are opened offline, previewed and drawn", async () => {
    const visit = await browser.page(files.url);
    await visit.evaluate(() => navigator.serviceWorker.ready);
    const context = visit.context();
    await context.setOffline(true);
    files.end();
    await visit.reload();
    await waitForState(visit, "ready", "true");
    await visit.close();
    const page = await context.newPage();
    await page.goto(`${files.url}?speed=20`);
    await waitForState(page, "ready", "true");
    await page.getByTestId("connect-sim").click();
    await waitForState(page, "lease", "mine");
    await sim.join(page);
    await page.goto(`${files.url}?speed=20#/run`);
    await waitForState(page, "route", "run");
    for (const name of ["house.svg", "rabbit.svg"]) {
      await openFile(page, name);
      await setOption(page, "at", "240 0");
      await page.getByTestId("setup-fit").check();
      await waitForValidCheck(page);
      const before = (await sim.call("world.look")).drawing.length;
      await page.getByTestId("run-start").click();
      await waitForState(page, "job", "running");
      await waitForState(page, "job", "done", 60_000);
      assert.ok((await sim.call("world.look")).drawing.length > before + 500, name);
    }
    await context.close();
  });

  test("files: a complaint about G-code is shown at its line", async () => {
    const page = await onRun();
    await openFile(page, {
      name: "far.nc",
      mimeType: "text/plain",
      buffer: Buffer.from("G21\nG90\nG0 X600 Y0 Z-50\nG1 X610 F1200\n"),
    });
    const complaint = page.getByTestId("run-complaint-1");
    await complaint.filter({ hasText: "line 3" }).waitFor();
    await complaint.click();
    await page.getByTestId("run-lines").filter({ hasText: "X600" }).waitFor();
    await closePage(page);
  });

  test("files: an image is traced, a plot and a drawing of CAD are checked", async () => {
    const page = await onRun();
    await openFile(page, "engrave_gradient.png");
    // A pen draws the outlines.
    await page.getByTestId("setup-tool").selectOption("pen");
    await setOption(page, "at", "240 0");
    await setOption(page, "width", "40");
    await waitForValidCheck(page);
    for (const name of ["star.plt", "plate.dxf"]) {
      await openFile(page, name);
      await setOption(page, "at", "240 0");
      await page.getByTestId("setup-fit").check();
      await waitForValidCheck(page);
    }
    await closePage(page);
  });

  test("files: the arm stops while a file of 14 MB is read", async () => {
    const page = await onRun();
    let text = "G21 G90\nG0 Z10\nG0 X200 Y0\nG1 Z0 F3000\n";
    for (let line = 0; text.length < 14e6; line++)
      text += `X${(220 + 20 * Math.cos(line / 50)).toFixed(3)}Y${(20 * Math.sin(line / 50)).toFixed(3)}\n`;
    await openFile(page, { name: "large.nc", mimeType: "text/plain", buffer: Buffer.from(text) });
    const { programs } = await sim.call("program.list");
    assert.ok(programs.some(({ name, bytes }) => name === "large.nc" && bytes === text.length));
    const check = sim.call("job.check", { program: "large.nc" });
    let isOver = false;
    check.finally(() => (isOver = true));
    // The second is answered after the first has been carried out.
    await sim.call("arm.stop");
    await sim.call("arm.stop");
    assert.ok(!isOver);
    assert.equal((await check).ok, true);
    await page.getByTestId("run-check").click();
    await page.getByText("The arm can do it").waitFor({ timeout: 120_000 });
    await closePage(page);
  });

  test("files: a newer build is offered, and activated only by a press", async () => {
    const page = await browser.page(files.url);
    await page.evaluate(() => navigator.serviceWorker.ready);
    await page.reload();
    await waitForState(page, "ready", "true");
    files.renew();
    await page.reload();
    await page.getByTestId("update-offer").waitFor();
    await page.reload();
    assert.equal(await page.title(), "Magician studio");
    await page.getByTestId("update-offer").click();
    await page.waitForFunction(() => document.title === "Newer Magician studio");
    await waitForState(page, "ready", "true");
    assert.equal(await page.getByTestId("update-offer").count(), 0);
    await closePage(page);
  });

  test("files: opened from a folder, the page states why it does not start", async () => {
    const context = await bench.browser.browser.newContext();
    const page = await context.newPage();
    await page.goto(`file://${join(folder, "index.html")}`);
    await page.getByText("the page was opened as a file").waitFor({ timeout: 10_000 });
    await context.close();
  });
  return files;
}
