// Tests of a class: thirty virtual arms, a teacher on a tablet, and two pupils who share an arm.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { readFileSync } from "node:fs";
import { createServer } from "node:net";
import { join } from "node:path";
import { Station, waitForState } from "./bench.mjs";
import { findings } from "./looks.mjs";

const SEATS = Array.from({ length: 30 }, (_, seat) => `seat${String(seat + 1).padStart(2, "0")}`);
const TABLET = { viewport: { width: 1024, height: 768 } };
/** Plan with one line on the paper. */
const LINE = JSON.stringify({
  format: "magician-plan",
  version: 1,
  steps: [
    [220, -20, -40, 0],
    [220, -20, -60, 0],
    [250, 20, -60, 0],
    [250, 20, -40, 0],
  ].map((move) => ({ move, by: "line" })),
});
const BURNS = JSON.stringify({ format: "magician-plan", version: 1, steps: [{ laser: true }, { laser: false }] });

/** Starts an arm behind a socket, which counts as a real one, and returns its port. */
async function realArm(program) {
  const free = createServer();
  await new Promise((done) => free.listen(0, "127.0.0.1", done));
  const { port } = free.address();
  await new Promise((done) => free.close(done));
  const child = spawn(program, ["sim", "--tcp", `127.0.0.1:${port}`], { stdio: ["ignore", "pipe", "ignore"] });
  await new Promise((done) => child.stdout.once("data", done));
  return { served: `tcp:127.0.0.1:${port}`, end: () => child.kill() };
}

export function classes(test, { browser, program, shots }) {
  const station = new Station(
    program,
    SEATS.flatMap((seat) => ["--arm", `${seat}=sim`]),
  );
  const named = async (name) => {
    const page = await browser.page(station.url);
    await page.evaluate((name) => localStorage.setItem("magician.name", name), name);
    await page.reload();
    await waitForState(page, "link", "up");
    return page;
  };
  const inClass = (name, body) =>
    test(`arms: ${name}`, async () => {
      await station.start();
      try {
        for (const arm of SEATS) await station.call("arm.clear_alarms", { arm });
        await body();
      } finally {
        for (const context of browser.browser.contexts()) await context.close();
        await station.end();
        station.state = new Station(program).state;
      }
    });
  const teacher = async (options = {}) => {
    const page = await browser.connected(`${station.url}#/arms`, { ...TABLET, ...options });
    await page.locator("[data-testid=fleet][data-ms] canvas").waitFor();
    return page;
  };
  const holder = async (arm) =>
    (await station.call("arm.list")).arms.find(({ name }) => name === arm).holder?.name ?? null;
  const until = async (what, is) => {
    for (const ends = Date.now() + 15_000; !(await is()); await new Promise((done) => setTimeout(done, 100)))
      assert.ok(Date.now() < ends, what);
  };

  inClass("thirty on a tablet: who has which, who asks, alarms, and all stop", async () => {
    const page = await teacher({ bypassCSP: true });
    const ada = await named("Ada");
    await ada.getByTestId("lease-take").click();
    await waitForState(ada, "lease", "mine");
    const ben = await named("Ben");
    await ben.getByTestId("lease-ask").click();
    await page.locator("[data-testid=arm-seat01][data-holder=Ada]").waitFor();
    await page.getByTestId("hand-seat01").getByText("Ben asks").waitFor();
    await station.call("world.fault", { arm: "seat07", fault: "alarm", alarm: 64 });
    await page.getByTestId("arm-seat07").getByText("Alarm 0x40").waitFor();
    await page.getByTestId("site-count").getByText("Arms: 30. Lost: 0. Alarms: 1. Jobs: 0. Raised hands: 1.").waitFor();
    const moving = SEATS.slice(9);
    for (const arm of moving) await station.call("arm.speed", { arm, percent: 1 });
    const moves = moving.map((arm) =>
      station.call("arm.move", { arm, to: [200, 180, 60, 0] }).then(
        () => "arrived",
        () => "stopped",
      ),
    );
    await until("moves", async () => (await station.pose("seat30")).moving);
    await page.waitForTimeout(1500);
    const spent = [];
    for (let look = 0; look < 12; look++) {
      spent.push(Number(await page.getByTestId("fleet").getAttribute("data-ms")));
      await page.waitForTimeout(60);
    }
    spent.sort((one, other) => one - other);
    console.log(`      30 arms: script of a frame ${spent[6]} ms in the middle, ${spent.at(-1)} ms at most`);
    assert.ok(spent[6] < 4, `${spent}`);
    await page.screenshot({ path: join(shots, "arms.png") });
    await page.getByTestId("stop-all").click();
    assert.deepEqual(new Set(await Promise.all(moves)), new Set(["stopped"]));
    assert.deepEqual(await findings(page), []);
    await page.emulateMedia({ colorScheme: "dark" });
    await page.waitForTimeout(400);
    assert.deepEqual(await findings(page), []);
    const over = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    assert.ok(over <= 0, `${over} px too wide`);
  });

  inClass("a program is sent to chosen arms, its pictures are kept, and control is taken and given", async () => {
    await station.call("program.put", { name: "line.plan.json", text: LINE });
    const { scenarios } = await station.call("world.scenarios", { arm: "seat03" });
    const sheet = scenarios.find(({ name }) => name === "drawing").text;
    for (const arm of ["seat03", "seat04"]) {
      await station.call("world.scenario", { arm, text: sheet });
      await station.call("arm.clear_alarms", { arm });
      await station.call("arm.speed", { arm, percent: 100 });
    }
    const page = await teacher();
    assert.ok(await page.getByTestId("site-send").isDisabled());
    for (const arm of ["seat03", "seat04"]) await page.getByRole("checkbox", { name: `Choose ${arm}` }).check();
    await page.getByTestId("site-program").selectOption("line.plan.json");
    await page.getByRole("button", { name: "Send to 2" }).click();
    await page.getByTestId("picture-seat04-line.plan").waitFor({ timeout: 30_000 });
    const [download] = await Promise.all([
      page.waitForEvent("download"),
      page.getByTestId("picture-seat03-line.plan").click(),
    ]);
    assert.equal(download.suggestedFilename(), "seat03-line.plan.svg");
    assert.match(readFileSync(await download.path(), "utf8"), /^<svg[\s\S]*<path/);
    assert.equal(await page.getByTestId("picture-seat05-line.plan").count(), 0);
    // A reloaded page has the pictures, one page with all of them is saved, and deleted ones do not
    // return.
    await page.reload();
    await waitForState(page, "link", "up");
    await page.getByTestId("picture-seat04-line.plan").waitFor();
    const [results] = await Promise.all([
      page.waitForEvent("download"),
      page.getByRole("button", { name: "Save all" }).click(),
    ]);
    const text = readFileSync(await results.path(), "utf8");
    assert.ok(
      results.suggestedFilename() === "results.html" &&
        text.match(/<figure>/g).length === 2 &&
        text.includes("seat04-line.plan"),
      text,
    );
    await page.getByRole("button", { name: "Delete seat04-line.plan" }).click();
    await page.getByTestId("picture-seat04-line.plan").waitFor({ state: "detached" });
    await page.reload();
    await page.getByTestId("picture-seat03-line.plan").waitFor();
    assert.equal(await page.getByTestId("picture-seat04-line.plan").count(), 0);
    await waitForState(page, "link", "up");
    for (const arm of ["seat03", "seat04"]) await page.getByRole("checkbox", { name: `Choose ${arm}` }).check();
    assert.ok((await holder("seat03")) !== null && (await holder("seat05")) === null);
    await page.getByTestId("site-give").click();
    await until("given back", async () => (await holder("seat03")) === null && (await holder("seat04")) === null);
    await page.getByTestId("choose-all").click();
    await page.getByTestId("site-take").click();
    await until("all taken", async () => (await holder("seat30")) !== null && (await holder("seat01")) !== null);
  });

  test("a program for several arms asks once which of them are real, and once more for a laser", async () => {
    const [one, two] = [await realArm(program), await realArm(program)];
    const mixed = new Station(program, [
      "--arm",
      "toy=sim",
      "--arm",
      `left=${one.served}`,
      "--arm",
      `right=${two.served}`,
    ]);
    await mixed.start();
    try {
      for (const [name, text] of [
        ["line.plan.json", LINE],
        ["burns.plan.json", BURNS],
      ])
        await mixed.call("program.put", { name, text });
      await mixed.call("arm.clear_alarms", { arm: "toy" });
      // No program runs on a real arm that was not homed.
      await Promise.all(["left", "right"].map((arm) => mixed.call("arm.home", { arm })));
      const page = await browser.connected(`${mixed.url}#/arms`, TABLET);
      const begun = async () => {
        const lists = await Promise.all(["toy", "left", "right"].map((arm) => mixed.call("job.list", { arm })));
        return lists.map(({ jobs }) => jobs.length);
      };
      const send = async (arms, name) => {
        for (const arm of ["toy", "left", "right"])
          await page.getByRole("checkbox", { name: `Choose ${arm}` }).setChecked(arms.includes(arm));
        await page.getByTestId("site-program").selectOption(name);
        await page.getByTestId("site-send").click();
      };
      await send(["toy", "left", "right"], "line.plan.json");
      await page
        .getByRole("alertdialog", { name: "Run line.plan.json on real arms?" })
        .getByText("These arms are real: left, right.")
        .waitFor();
      assert.deepEqual(await begun(), [0, 0, 0]);
      const holders = (await mixed.call("arm.list")).arms.map(({ holder }) => holder);
      assert.deepEqual(holders, [null, null, null], "nothing is taken before the question is answered");
      await page.getByTestId("confirm-no").click();
      await page.waitForTimeout(500);
      assert.deepEqual(await begun(), [0, 0, 0]);
      // A virtual arm alone needs no confirmation.
      await send(["toy"], "line.plan.json");
      await page.getByTestId("notice").getByText("Done on 1 arms.").waitFor();
      assert.equal(await page.getByTestId("confirm").count(), 0);
      for (const arm of ["left", "right"]) assert.equal((await mixed.pose(arm)).holder, null);
      await send(["left", "right"], "burns.plan.json");
      await page.getByTestId("confirm-yes").click();
      await page
        .getByRole("alertdialog", { name: "Start with the laser" })
        .getByText(/left: .*laser.*right: .*laser/)
        .waitFor();
      await page.getByTestId("confirm-no").click();
      await page.waitForTimeout(500);
      const states = async () =>
        (await Promise.all(["left", "right"].map((arm) => mixed.call("job.list", { arm })))).map(
          ({ jobs }) => jobs.at(-1)?.state,
        );
      assert.ok(
        (await states()).every((state) => state !== "done" && state !== "running"),
        `${await states()}`,
      );
      await send(["left", "right"], "burns.plan.json");
      await page.getByTestId("confirm-yes").click();
      await page.getByRole("alertdialog", { name: "Start with the laser" }).waitFor();
      await page.getByTestId("confirm-yes").click();
      await until("both have run", async () => (await states()).every((state) => state === "done"));
      await page.context().close();
    } finally {
      await mixed.end();
      one.end();
      two.end();
    }
  });

  test("a class: pupils sign in by name and code, take turns, and a teacher freezes, sends and has the results", async () => {
    const left = new Station(program, ["--arm", "left=sim"]);
    await left.start();
    try {
      await left.call("program.put", { name: "line.plan.json", text: LINE });
      await left.call("arm.clear_alarms", { arm: "left" });
      const text =
        '[class]\nturn_s = 600\npin = "482913"\n[[pupil]]\nname = "Ada"\ncode = "7K3M"\n[[pupil]]\nname = "Ben"\ncode = "8P4R"\n';
      await left.call("class.set", { text });
      left.pin = "482913";
      const signIn = async (page, name, code) => {
        await page.getByTestId("class-name").fill(name);
        await page.getByTestId("class-code").fill(code);
        await page.getByTestId("class-signin").click();
      };
      const pupil = async (name, code) => {
        // Without an address of its own the page opens at the sign-in.
        const page = await browser.connected(left.url, TABLET);
        await waitForState(page, "route", "class");
        await signIn(page, name, code);
        return page;
      };
      const ada = await pupil("Ada", "0000");
      await ada.getByText("Name or code is wrong: both are on the slip of paper.").waitFor();
      await signIn(ada, "Ada", "7k3m");
      await ada.getByRole("button", { name: "Join the queue" }).click();
      await ada.getByTestId("notice").getByText("It is your turn: left is yours.").waitFor();
      await ada
        .getByTestId("header-turn")
        .getByText(/left: Ada’s turn (10:00|9:5\d)/)
        .waitFor();
      const ben = await pupil("Ben", "8P4R");
      await ben.getByRole("button", { name: "Join the queue" }).click();
      await ben.getByTestId("header-turn").getByText("Place 1 in the queue").waitFor();
      // A reloaded page keeps its pupil.
      await ben.reload();
      await ben.getByTestId("header-turn").getByText("Place 1 in the queue").waitFor();
      const page = await browser.connected(`${left.url}#/class`, TABLET);
      await page.getByTestId("class-teacher").click();
      await page.getByTestId("class-pin").fill("000000");
      await page.getByTestId("class-pin-signin").click();
      await page.getByText("The PIN is wrong.").waitFor();
      await page.getByTestId("class-pin").fill("482913");
      await page.getByTestId("class-pin-signin").click();
      await page.getByTestId("turn-left").getByText("Ada’s turn").waitFor();
      await page.getByTestId("class-freeze-all").click();
      await ada.getByTestId("header-turn").getByText("left: Frozen").waitFor();
      await ada.goto(`${left.url}#/move`);
      await ada
        .getByTestId("jog-status")
        .getByText(/frozen/)
        .waitFor();
      assert.ok(await ada.getByTestId("home").isDisabled(), "a pupil's frozen arm says so at its buttons");
      await page.screenshot({ path: join(shots, "class.png") });
      assert.deepEqual(await findings(page), []);
      await page.getByTestId("class-free").click();
      await ada.getByTestId("header-turn").getByText("Ada’s turn").waitFor();
      const { job } = await left
        .call("class.send", { program: "line.plan.json", arms: ["left"] })
        .then(({ jobs: [sent] }) => sent);
      assert.equal((await left.call("job.get", { job })).state, "queued", "a teacher's program waits for the turns");
      await page
        .getByTestId("queued-left")
        .getByText(/line.*somebody else’s turn/)
        .waitFor();
      await ada.goto(`${left.url}#/class`);
      await ada.getByRole("button", { name: "I am done" }).click();
      await ben.getByTestId("header-turn").getByText("left: Ben’s turn").waitFor();
      await ben.getByRole("button", { name: "I am done" }).click();
      await until("it has run", async () => (await left.call("job.get", { job })).state === "done");
      const [results] = await Promise.all([page.waitForEvent("download"), page.getByTestId("class-results").click()]);
      assert.match(readFileSync(await results.path(), "utf8"), /What the class has made/);
    } finally {
      for (const context of browser.browser.contexts()) await context.close();
      await left.end();
    }
  });
}
