// Basis of the suite: a station with a virtual arm, a browser, and direct calls to the station.
import { spawn } from "node:child_process";
import { once } from "node:events";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { setTimeout as sleep } from "node:timers/promises";
import { chromium } from "playwright-core";

const BROWSER_FLAGS = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"];

/**
 * Expected messages of the browser's console: a stopped station refuses connections, a test
 * disconnects the network, and one of the headers has no effect over plain HTTP.
 */
const EXPECTED_ERRORS =
  /ERR_CONNECTION|ERR_INTERNET_DISCONNECTED|WebSocket connection|Cross-Origin-Opener-Policy header has been ignored/;

/** `magician serve` as users start it. */
export class Station {
  /** `served` are its arguments; one virtual arm by default. */
  constructor(program, served = ["--port", "sim"]) {
    this.program = program;
    this.served = served;
    this.state = mkdtempSync(join(tmpdir(), "studio-"));
    this.listen = "127.0.0.1:0";
  }

  async start(...more) {
    const words = ["serve", ...this.served, "--listen", this.listen, "--json", ...more];
    this.env = {
      ...process.env,
      XDG_STATE_HOME: this.state,
      XDG_DATA_HOME: this.state,
      XDG_CONFIG_HOME: this.state,
      MAGICIAN_PORT: undefined,
    };
    this.child = spawn(this.program, words, { env: this.env, stdio: ["ignore", "pipe", "inherit"] });
    let said = "";
    for await (const piece of this.child.stdout) {
      said += piece;
      if (said.includes("\n")) break;
    }
    this.url = JSON.parse(said).url;
    this.listen = new URL(this.url).host;
  }

  async kill(signal = "SIGKILL") {
    // A test that fails after a kill must not wait for the station to end.
    if (this.child.exitCode !== null || this.child.signalCode !== null) return;
    const over = once(this.child, "exit");
    this.child.kill(signal);
    await over;
  }

  async end() {
    await this.kill("SIGTERM");
    rmSync(this.state, { recursive: true, force: true });
  }

  /** Calls the station without the page; in a class with this PIN as the teacher. */
  async call(method, params = {}) {
    const body = JSON.stringify({ jsonrpc: "2.0", id: 1, method, params });
    const headers = {
      "content-type": "application/json",
      ...(this.pin ? { authorization: `Bearer ${this.pin}` } : {}),
    };
    const answer = await fetch(`${this.url}api/v1/rpc`, { method: "POST", headers, body });
    const { result, error } = await answer.json();
    if (error) throw new Error(`${method}: ${error.message}`);
    return result;
  }

  isRunning() {
    return fetch(`${this.url}healthz`).then(
      () => true,
      () => false,
    );
  }

  pose(arm) {
    return this.call("arm.state", arm ? { arm } : {});
  }

  /** Waits until the state of the arm meets a condition. */
  async until(what, is, within = 10_000) {
    const ends = Date.now() + within;
    for (;;) {
      const state = await this.pose();
      if (is(state)) return state;
      if (Date.now() > ends) throw new Error(`the arm: ${what}: ${JSON.stringify(state)}`);
      // A state is read again after 100 ms.
      await sleep(120);
    }
  }

  /** Waits until two consecutive readings are equal. */
  async waitForRest() {
    let before = null;
    return this.until("stands", (state) => {
      const now = ["x", "y", "z", "r"].map((name) => state[name]).join();
      const same = now === before && !state.moving && state.jog === null;
      before = now;
      return same;
    });
  }

  async events() {
    return (await this.call("events.since", { seq: 0 })).events;
  }
}

/** Pages of a browser, and all errors that it reports in them. */
export class Browser {
  complaints = [];

  async start() {
    this.browser = await chromium.launch({
      executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
      args: BROWSER_FLAGS,
    });
  }

  async page(url, options = {}) {
    const { init, processor = false, clock = false, ...rest } = options;
    const context = await this.browser.newContext({ viewport: { width: 1280, height: 860 }, ...rest });
    const page = await context.newPage();
    if (init) await page.addInitScript(init);
    // The test controls the timers of the page.
    if (clock) await page.clock.install();
    // Pretends that there is a graphics chip, as most users have one; here the processor renders.
    if (!processor)
      await page.addInitScript(() => {
        const get = WebGL2RenderingContext.prototype.getExtension;
        WebGL2RenderingContext.prototype.getExtension = function (name) {
          return name === "WEBGL_debug_renderer_info" ? null : get.call(this, name);
        };
      });
    await page.addInitScript(() => {
      document.addEventListener("securitypolicyviolation", (event) =>
        console.error(`CSP: ${event.violatedDirective} ${event.blockedURI}`),
      );
    });
    page.on("console", (message) => {
      if (message.type() === "error" && !EXPECTED_ERRORS.test(message.text())) this.complaints.push(message.text());
    });
    page.on("pageerror", (error) => this.complaints.push(String(error)));
    page.on("request", (request) => {
      const to = new URL(request.url());
      if (to.protocol.startsWith("http") && to.origin !== new URL(url).origin) this.complaints.push(`asked ${to}`);
    });
    await page.goto(url);
    await waitForState(page, "ready", "true");
    return page;
  }

  /** Opens a page and waits until it is connected. */
  async connected(url, options) {
    const page = await this.page(url, options);
    await waitForState(page, "link", "up");
    await waitForState(page, "stale", "false");
    return page;
  }

  /** Opens a page and takes control. */
  async inControl(url, options) {
    const page = await this.connected(url, options);
    await page.getByTestId("lease-take").click();
    await waitForState(page, "lease", "mine");
    return page;
  }

  end() {
    return this.browser.close();
  }
}

/** Waits for a value of the body's data attributes. */
export async function waitForState(page, name, value, within = 20_000) {
  try {
    await page.waitForFunction(([name, value]) => document.body.dataset[name] === value, [name, value], {
      timeout: within,
    });
  } catch {
    const said = await page.evaluate(() => JSON.stringify(document.body.dataset));
    throw new Error(`data-${name} is not ${value}: ${said}`);
  }
}

export const near = (one, two, within = 0.02) => Math.abs(one - two) <= within;
