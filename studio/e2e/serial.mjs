// The suite for the third kind of line: a real arm at a serial port of the browser, checked by the
// bytes and the pose of the virtual arm behind it.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { setTimeout as sleep } from "node:timers/promises";
import { Browser, waitForState } from "./bench.mjs";
import { Cable, mockOf } from "./port.mjs";
import { Files, SHARED_TESTS, Sim } from "./sim.mjs";

/** Commands by their ids in the protocol. */
const [JOG, CP, BURN, PTP, LASER, CLEAR] = [73, 91, 92, 84, 61, 245];
/** Longest duration of a jog after its last byte, ms: its `keep_ms` and 50. */
const STOP_LIMIT_MS = 300;
/** Exposes the worker to the test, so that it can be terminated. */
const EXPOSE_WORKERS = `globalThis.workers = []; Worker = class extends Worker { constructor(...all) { super(...all); globalThis.workers.push(this); } };`;
/** Moves for some seconds, in many commands. */
const PLAN = JSON.stringify({
  format: "magician-plan",
  version: 1,
  steps: Array.from({ length: 12 }, (_, nth) => ({ move: [220, nth % 2 ? 60 : -60, 40, 0] })),
});

class SerialBrowser extends Browser {
  constructor(other, sim, cable) {
    super();
    this.other = other;
    this.complaints = other.complaints;
    this.sim = sim;
    this.cable = cable;
  }

  get browser() {
    return this.other.browser;
  }

  page(url, options = {}) {
    return super.page(url, { ...options, init: { content: EXPOSE_WORKERS + mockOf(this.cable.bridge) } });
  }

  async connected(url, options) {
    const page = await this.page(url, options);
    await page.getByTestId("connect-serial").click();
    await waitForState(page, "link", "up");
    await waitForState(page, "stale", "false");
    await this.sim.join(page);
    return page;
  }
}

export function onSerial(tests, shared, bench, folder) {
  const files = new Files(folder);
  const sim = Object.assign(new Sim("none"), { asks: true });
  const cable = new Cable(bench.program);
  const browser = new SerialBrowser(bench.browser, sim, cable);
  const test = (name, body) => {
    tests.push([
      `port: ${name}`,
      async () => {
        await files.start();
        await cable.start();
        Object.assign(cable, {
          granted: true,
          there: cable.there || 1,
          isBusy: false,
          isMute: false,
          piece: Infinity,
          noise: false,
        });
        files.patched.set(
          "assets/worker.js",
          mockOf(cable.bridge) + readFileSync(join(folder, "assets/worker.js"), "utf8"),
        );
        bench.swap({ station: sim, browser, url: () => files.url });
        cable.sent = [];
        await body();
        assert.ok(
          !cable.sent.some((frame) => frame.id === JOG && frame.params[1] !== 0),
          "a jog of the arm's own was sent",
        );
      },
    ]);
  };
  const closePage = (page) => page.context().close();
  const moving = (frame) => frame.id === CP || frame.id === PTP;

  /** Opens a page that holds a jog. */
  const jogging = async (page) => {
    await page.getByTestId("jog-j1-plus").hover();
    // On a busy machine the page may be too late to keep the jog alive, and it ends.
    for (let tries = 0; ; tries++) {
      await page.mouse.down();
      for (let looks = 0; looks < 20; looks++) if (await cable.moves()) return;
      assert.ok(tries < 5, await page.getByTestId("jog-status").textContent());
      await page.mouse.up();
      await waitForState(page, "jog", "idle");
    }
  };
  /** Opens a page and homes its arm, without which it runs no program. */
  const homed = async (page) => {
    await page.goto(`${files.url}#/move`);
    await page.getByTestId("home").click();
    await page.getByTestId("confirm-yes").click();
    await waitForState(page, "moving", "true");
    await waitForState(page, "moving", "false", 60_000);
    await waitForState(page, "alarm", "false");
    cable.sent = [];
  };
  const running = async (page) => {
    await homed(page);
    await page.goto(`${files.url}#/run`);
    await page
      .getByTestId("program-open")
      .setInputFiles({ name: "there.plan.json", mimeType: "text/plain", buffer: Buffer.from(PLAN) });
    await page.locator('[data-testid="program-there.plan.json"][aria-selected=true]').waitFor();
    await page.getByText("The arm can do it").waitFor();
    await page.getByTestId("run-start").click();
    await page.getByTestId("confirm").getByText("keep it open").waitFor();
    assert.ok(!cable.sent.some(moving), "nothing moves before the question is answered");
    await page.getByTestId("confirm-yes").click();
    await waitForState(page, "job", "running");
    await cable.untilMoves();
  };
  /** After the last byte a jogging arm must rest in time, and no byte may follow. */
  const standsInTime = async () => {
    const ms = await cable.hasMovedOn(moving);
    console.log(`      moved for ${ms.toFixed(0)} ms after the last byte`);
    assert.ok(ms > 0 && ms <= STOP_LIMIT_MS, `it moved for ${ms} ms after the last byte`);
    await sleep(300);
    assert.ok(!(await cable.moves()));
  };

  test("connecting sends nothing that moves, queues or clears, and takes no control", async () => {
    const page = await browser.page(files.url);
    assert.match(await page.getByTestId("serial-why").textContent(), /only reads/);
    await page.getByRole("button", { name: "USB" }).click();
    await waitForState(page, "link", "up");
    await waitForState(page, "backend", "serial");
    await waitForState(page, "lease", "free");
    assert.equal(await page.getByTestId("header-arm").textContent(), "Real arm");
    await page.getByTestId("jog-note").waitFor();
    await sleep(2000);
    assert.ok(cable.sent.length > 20);
    assert.deepEqual(
      cable.sent.filter((frame) => frame.ctrl !== 0),
      [],
    );
    await page.goto(`${files.url}#/arms`);
    const [file] = await Promise.all([page.waitForEvent("download"), page.getByTestId("log-export").click()]);
    assert.equal(file.suggestedFilename(), "magician.pcapng");
    const said = execFileSync(bench.program, ["decode", "--json", await file.path()], { encoding: "utf8" });
    const lines = said
      .trim()
      .split("\n")
      .map((line) => JSON.parse(line));
    assert.ok(lines.length > 40 && lines.every(({ ok }) => ok), said.slice(0, 500));
    assert.ok(lines.some(({ command, direction }) => command === "GetPose" && direction === "reply"));
    await page.reload();
    await waitForState(page, "ready", "true");
    await sleep(500);
    await waitForState(page, "backend", "none");
    assert.ok(await page.getByTestId("connect-serial").isEnabled());
    await closePage(page);
  });

  test("a closed port picker is no fault; a busy port and a silent arm are reported", async () => {
    const page = await browser.page(files.url);
    const press = () => page.getByTestId("connect-serial").click();
    const says = (text) => page.getByTestId("serial-why").filter({ hasText: text }).waitFor();
    cable.granted = false;
    await press();
    await sleep(500);
    await waitForState(page, "backend", "none");
    await says("only reads");
    assert.equal((await page.getByTestId("notice").textContent()).trim(), "");
    Object.assign(cable, { granted: true, isBusy: true });
    await press();
    await says("magician serve");
    await waitForState(page, "backend", "none");
    Object.assign(cable, { isBusy: false, isMute: true });
    await press();
    await says("no arm answers");
    cable.isMute = false;
    await press();
    await waitForState(page, "link", "up");
    await closePage(page);
  });

  test("a browser without serial ports gets the reason", async () => {
    for (const [secure, text] of [
      [true, "Chrome or Edge"],
      [false, "through a server"],
    ]) {
      const context = await browser.browser.newContext();
      const page = await context.newPage();
      await page.addInitScript((secure) => {
        delete Navigator.prototype.serial;
        Object.defineProperty(globalThis, "isSecureContext", { value: secure });
      }, secure);
      await page.goto(files.url);
      await page.getByTestId("serial-why").filter({ hasText: text }).waitFor();
      assert.ok(await page.getByTestId("connect-serial").isDisabled());
      await context.close();
    }
  });

  /**
   * Repeats a test if the jog ended early: on a busy machine a worker may be too late for its
   * keep-alives.
   */
  const again = (body) => async () => {
    for (let tries = 1; ; tries++) {
      try {
        return await body();
      } catch (error) {
        const ends = (await sim.events().catch(() => []))
          .filter((event) => event.why !== undefined)
          .map((event) => event.why);
        console.log(`      jogs ended: ${ends}: ${error.message.slice(0, 60)}`);
        if (tries === 3 || !ends.includes("not-kept")) throw error;
        for (const context of browser.browser.contexts()) await context.close();
      }
    }
  };
  for (const [name, body] of shared) if (SHARED_TESTS.includes(name)) test(name, again(body));

  test("home and laser ask for confirmation", async () => {
    const page = await browser.inControl(files.url);
    for (const button of ["home", "tool-laser"]) {
      if (button === "tool-laser") await page.getByTestId("tool-select").selectOption("laser");
      const began = performance.now();
      await page.getByTestId(button).click();
      await page.getByTestId("confirm-no").click();
      await sleep(300);
      assert.ok(!cable.since(began).some((frame) => frame.id === 31 || (frame.id === LASER && frame.ctrl)));
    }
    assert.ok(!(await cable.burns()));
    await closePage(page);
  });

  test("reads in single bytes, noise between frames and errors of the stream lose nothing", async () => {
    Object.assign(cable, { piece: 1, noise: true });
    const page = await browser.inControl(files.url);
    const { opens } = cable;
    for (const error of ["BufferOverrunError", "FramingError", "BreakError", "ParityError"]) {
      cable.error(error);
      await sleep(300);
      await waitForState(page, "link", "up");
    }
    assert.equal(cable.opens, opens, "the port was lost");
    await page.getByTestId("jog-mode-step").check({ force: true });
    const before = await cable.pose();
    await page.getByTestId("jog-z-plus").click();
    await sim.until("a step", (state) => Math.abs(state.z - before[2] - 5) < 0.02 && !state.moving);
    assert.equal(cable.sent.filter(moving).length, 1);
    await closePage(page);
  });

  for (const [what, kill] of [
    ["a worker that is ended", (page) => page.evaluate(() => globalThis.workers[0].terminate())],
    [
      "a worker that hangs",
      (page) =>
        void page
          .workers()[0]
          .evaluate(() => {
            for (const ends = performance.now() + 4000; performance.now() < ends; );
          })
          .catch(() => {}),
    ],
    ["a page that is closed", (page) => page.close()],
    ["a page that is left", (page) => page.goto("about:blank")],
    ["a browser window that is gone", (page) => page.context().close()],
    ["a cable that is pulled", () => cable.unplug()],
  ]) {
    test(`during a jog, ${what}: the arm stops in time`, async () => {
      const page = await browser.inControl(files.url);
      await jogging(page);
      await kill(page);
      await standsInTime();
      await page
        .context()
        .close()
        .catch(() => {});
      cable.plug();
    });
  }

  test("leaving the page stops a job, with the laser off, within 300 ms", async () => {
    for (const leave of [(page) => page.goto("about:blank"), (page) => page.close()]) {
      cable.sent = [];
      const page = await browser.inControl(files.url);
      page.on("dialog", (dialog) => void dialog.accept());
      await running(page);
      const began = performance.now();
      await leave(page);
      await sleep(400);
      const stop = cable.since(began).find((frame) => frame.id === CLEAR);
      assert.ok(stop !== undefined, "no stop was sent");
      console.log(`      stop ${(stop.at - began).toFixed(0)} ms after it began to go`);
      assert.ok(
        cable.since(began).some((frame) => frame.id === LASER && frame.params[1] === 0),
        "laser off",
      );
      assert.ok(!(await cable.moves()) && !(await cable.burns()));
      await page.context().close();
    }
  });

  test("leaving the page during an engraving sends laser off in time", async () => {
    cable.sent = [];
    const page = await browser.inControl(files.url);
    page.on("dialog", (dialog) => void dialog.accept());
    await homed(page);
    await page.goto(`${files.url}#/engrave`);
    const svg =
      '<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="30mm" viewBox="0 0 60 30"><path d="M0 0H60V30H0Z" fill="none" stroke="#000"/></svg>';
    await page
      .getByTestId("draw-open")
      .setInputFiles({ name: "engraved.svg", mimeType: "image/svg+xml", buffer: Buffer.from(svg) });
    await page.getByTestId("setup-surface").fill("-40");
    await page.getByTestId("setup-surface").press("Tab");
    await page.locator("[data-testid=draw-preview][data-shown=true]").waitFor();
    assert.ok(await page.getByTestId("draw-start").isDisabled());
    await page.getByTestId("laser-arm").click();
    await page.getByTestId("draw-start").click();
    await page.getByTestId("confirm").getByText("moves by itself").waitFor();
    await page.getByTestId("confirm-yes").click();
    await page.getByTestId("confirm").getByText("may switch the laser on").waitFor();
    assert.doesNotMatch(await page.getByTestId("confirm").textContent(), /"yes"/);
    assert.ok(!cable.sent.some((frame) => moving(frame)), "nothing moves before both questions are answered");
    await page.getByTestId("confirm-yes").click();
    await waitForState(page, "job", "running");
    const isBurning = () => cable.sent.some((frame) => frame.id === BURN && frame.params.length === 17);
    for (let looks = 0; looks < 400 && !isBurning(); looks++) await sleep(50);
    assert.ok(isBurning(), "nothing burns yet");
    await cable.untilMoves();
    const began = performance.now();
    await page.close();
    await sleep(400);
    const since = cable.since(began);
    const stop = since.find((frame) => frame.id === CLEAR);
    assert.ok(stop !== undefined, "no stop was sent");
    console.log(`      stop ${(stop.at - began).toFixed(0)} ms after it began to go`);
    assert.ok(
      since.some((frame) => frame.id === LASER && frame.params[1] === 0),
      "laser off",
    );
    assert.ok(!since.some((frame) => frame.id === BURN && frame.at > stop.at), "it is sent more to burn");
    // A burning path burns only while the arm moves along it.
    assert.ok(!(await cable.burns()) && !(await cable.moves()));
    await page.context().close();
  });

  test("a pulled cable during a job is reported and reconnected, and nothing is sent twice", async () => {
    const page = await browser.inControl(files.url);
    await running(page);
    cable.unplug();
    await waitForState(page, "link", "lost");
    await page.getByTestId("link-since").waitFor();
    await waitForState(page, "job", "interrupted");
    await page.goto(`${files.url}#/move`);
    assert.ok(await page.getByTestId("jog-x-plus").isDisabled());
    await waitForState(page, "stale", "true");
    const count = cable.sent.filter(moving).length;
    await cable.timeOfRest(15_000);
    const plugged = performance.now();
    cable.plug();
    await waitForState(page, "link", "up");
    await waitForState(page, "stale", "false");
    await sleep(500);
    assert.ok(!cable.since(plugged).some(moving), "it goes on by itself");
    assert.equal(cable.sent.filter(moving).length, count);
    assert.ok(!(await cable.burns()));
    await closePage(page);
  });

  test("a new name and a hanging worker keep port, control and motion", async () => {
    const page = await browser.inControl(files.url);
    await page.goto(`${files.url}#/settings`);
    await page.getByTestId("settings-name").fill("Ada");
    await page.getByTestId("settings-name").press("Tab");
    await page.getByTestId("lease-holder").filter({ hasText: "You have control" }).waitFor();
    await waitForState(page, "link", "up");
    await running(page);
    void page
      .workers()[0]
      .evaluate(() => {
        for (const ends = performance.now() + 4000; performance.now() < ends; );
      })
      .catch(() => {});
    await waitForState(page, "link", "lost");
    await waitForState(page, "link", "up");
    await waitForState(page, "backend", "serial");
    assert.ok(!cable.sent.some((frame) => frame.id === CLEAR && frame.ctrl), "nothing was stopped");
    await page.getByTestId("run-stop").click();
    await waitForState(page, "job", "stopped");
    await closePage(page);
  });

  test("a worker that checks a large program does not count as dead", async () => {
    const page = await browser.inControl(files.url);
    // As long as a large program takes on a slow computer, and longer than the timeout for a worker
    // that hangs.
    await page.workers()[0].evaluate(() => {
      addEventListener("message", ({ data }) => {
        if (data.kind === "send" && data.message.method === "job.check")
          for (const ends = performance.now() + 13_000; performance.now() < ends; );
      });
    });
    await page.evaluate(() => {
      globalThis.links = [];
      new MutationObserver(() => globalThis.links.push(document.body.dataset.link)).observe(document.body, {
        attributeFilter: ["data-link"],
      });
    });
    await page.goto(`${files.url}#/run`);
    await page
      .getByTestId("program-open")
      .setInputFiles({ name: "large.plan.json", mimeType: "text/plain", buffer: Buffer.from(PLAN) });
    await waitForState(page, "stale", "true");
    await page.getByText("The arm can do it").waitFor();
    await waitForState(page, "stale", "false");
    assert.deepEqual(
      (await page.evaluate(() => globalThis.links)).filter((link) => link !== "up"),
      [],
    );
    await waitForState(page, "backend", "serial");
    await closePage(page);
  });

  test("a terminated worker is detected, and the port can be chosen again", async () => {
    const page = await browser.connected(files.url);
    await page.evaluate(() => globalThis.workers[0].terminate());
    await waitForState(page, "link", "lost");
    await waitForState(page, "backend", "none", 20_000);
    await page.getByTestId("serial-why").filter({ hasText: "has ended" }).waitFor();
    await page.getByTestId("connect-serial").click();
    await waitForState(page, "link", "up");
    await closePage(page);
  });

  const end = () => {
    files.end();
    cable.end();
  };
  return { end };
}
