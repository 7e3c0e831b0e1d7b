// Test of a lesson at one computer: ten virtual arms, a teacher's page, and pupils on a phone, a
// tablet and a desktop.
import assert from "node:assert/strict";
import { join } from "node:path";
import { Station, waitForState } from "./bench.mjs";
import { findings } from "./looks.mjs";

const ARMS = Array.from({ length: 10 }, (_, nth) => `a${nth + 1}`);
const NAMES = ["Ada", "Ben", "Chen Li", "Dora", "Emil", "Fatima", "Georg", "Hanna"];
const PHONE = { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true, bypassCSP: true };
const TABLET = { viewport: { width: 820, height: 1180 }, hasTouch: true, bypassCSP: true };
const DESKTOP = { viewport: { width: 1440, height: 900 }, bypassCSP: true };

/** Hides or shows the page, as a browser does. */
const hide = (page, is) =>
  page.evaluate((is) => {
    Object.defineProperty(document, "hidden", { configurable: true, get: () => is });
    document.dispatchEvent(new Event("visibilitychange"));
  }, is);

export function lesson(test, { browser, program, shots, At = Station }) {
  test("a lesson: made, signed in, turns, freeze over kill -9, a reload, a wrong code, results, end", async () => {
    const station = new At(
      program,
      ARMS.flatMap((arm) => ["--arm", `${arm}=sim`]),
    );
    await station.start();
    const says = (page, id, text) => page.getByTestId(id).getByText(text).first().waitFor();
    let shot = 0;
    /** Takes a screenshot of a step. It must fit the screen, without findings of axe. */
    const look = async (page, name, { whole = true } = {}) => {
      await page.waitForTimeout(350);
      await page.screenshot({
        path: join(shots, `lesson-${String(++shot).padStart(2, "0")}-${name}.png`),
        fullPage: whole,
      });
      const over = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
      assert.ok(over <= 0, `${name}: ${over} px too wide`);
      assert.deepEqual(await findings(page), [], name);
    };
    try {
      // Made from pasted names.
      const teacher = await browser.connected(`${station.url}#/class`, DESKTOP);
      const pasted = `${NAMES.slice(0, 4).join("\n")}\n\n ${NAMES.slice(4).join(", ")}`;
      await teacher.getByTestId("class-names").fill(`${pasted}, ada`);
      await teacher.getByText("Two pupils are called ada").waitFor();
      assert.ok(await teacher.getByTestId("class-make").isDisabled(), "two pupils of one name");
      await teacher.getByTestId("class-names").fill(pasted);
      await teacher.getByTestId("class-arm-a10").uncheck();
      await teacher.getByTestId("class-turn").fill("10");
      await look(teacher, "make");
      await teacher.getByTestId("class-make").click();
      await says(teacher, "class-pupils", "Hanna");
      await waitForState(teacher, "lease", "free");
      assert.equal(await teacher.getByTestId("class-pupils").locator("tbody tr").count(), NAMES.length);
      await says(teacher, "class-count", "Missing: 8.");
      // The slips contain what a pupil needs to sign in.
      await teacher.getByTestId("class-slips").click();
      const slips = {};
      for (const name of NAMES) {
        const slip = teacher.getByTestId(`slip-${name}`);
        const code = await slip.locator(".slip-code").textContent();
        const address = await slip.locator("a").getAttribute("href");
        assert.equal(address, `${station.url}#/class?${new URLSearchParams({ name, code })}`);
        assert.ok(await slip.locator("img").evaluate((image) => image.naturalWidth > 20));
        slips[name] = { code, address };
      }
      await look(teacher, "slips");
      await teacher.emulateMedia({ media: "print" });
      assert.ok(
        !(await teacher.getByTestId("stop").isVisible()) && (await teacher.getByTestId("slip-Hanna").isVisible()),
      );
      await teacher.screenshot({ path: join(shots, "lesson-slips-print.png"), fullPage: true });
      await teacher.emulateMedia({ media: null });
      await teacher.getByTestId("slips-back").click();
      // A slip fills in the sign-in form, and its code does not remain in the address.
      const ada = await browser.page(slips.Ada.address, PHONE);
      await ada.getByTestId("class-signin").waitFor();
      assert.equal(new URL(ada.url()).hash, "#/class");
      await look(ada, "door-phone");
      await ada.getByTestId("class-signin").click();
      await says(ada, "mine-arm", "You have no arm now.");
      await look(ada, "pupil-phone");
      for (const hidden of ["stop-all", "site-file", "connect-serial", "station-token", "station-url", "lease-take"])
        assert.equal(await ada.getByTestId(hidden).count(), 0, hidden);
      // A wrong code is reported beside its field.
      const ben = await browser.page(station.url, TABLET);
      await ben.getByTestId("class-name").fill("Ben");
      await ben.getByTestId("class-code").fill("0000");
      await ben.getByTestId("class-signin").click();
      await ben.getByText("Name or code is wrong: both are on the slip of paper.").waitFor();
      await look(ben, "wrong-code-tablet");
      await ben.getByTestId("class-code").fill(slips.Ben.code.toLowerCase());
      await ben.getByTestId("class-signin").click();
      await says(ben, "mine-place", "You are in no queue.");
      const chen = await browser.page(slips["Chen Li"].address, DESKTOP);
      await chen.getByTestId("class-signin").click();
      await says(chen, "mine-arm", "You have no arm now.");
      // Turns: one arm for two pupils, and a third pupil waits.
      for (const [page, first] of [
        [ada, true],
        [ben, false],
        [chen, false],
      ]) {
        await page.getByTestId("join-arm").selectOption("a1");
        await page.getByTestId("turn").click();
        await says(page, first ? "mine-arm" : "mine-place", first ? "a1" : page === ben ? "Place 1" : "Place 2");
      }
      await says(ada, "mine-arm", /(10:00|9:\d\d) left/);
      await look(ada, "turn-phone");
      await look(chen, "place-desktop");
      await says(teacher, "pupil-Ada", "Has a1");
      await says(teacher, "pupil-Ben", "Place 1 in the queue");
      await says(teacher, "class-count", "Signed in: 3. Waiting: 2. Missing: 5.");
      await says(teacher, "turn-a1", "Ada’s turn");
      await says(teacher, "arm-a10", "Teacher only");
      await look(teacher, "teacher");
      // An arm reserved for the teacher offers no place in a queue.
      const ways = await chen.getByTestId("join-arm").count();
      assert.equal(ways, 0, "who waits joins nothing else");
      // Freeze all applies to all arms, whatever is selected.
      await teacher.getByRole("checkbox", { name: "Choose a3" }).check();
      assert.equal(await teacher.getByTestId("class-freeze-chosen").textContent(), "Freeze 1");
      await teacher.getByTestId("class-freeze-all").click();
      await says(teacher, "class-frozen", "Frozen: 10 of 10 arms.");
      await says(ada, "mine-arm", "Frozen by the teacher.");
      await look(teacher, "frozen");
      await look(ada, "frozen-phone");
      // .. and persists across restarts of the station.
      await station.kill();
      await ben.getByText("No connection since").waitFor();
      await waitForState(teacher, "link", "lost");
      assert.equal(await teacher.locator(".tile.lost").count(), ARMS.length);
      assert.equal(
        await teacher.locator(".tile .who", { hasText: "free" }).count(),
        0,
        "no arm is free at a station that is gone",
      );
      await says(teacher, "class-pupils", "Hanna");
      await look(teacher, "killed");
      await station.start();
      await says(teacher, "class-frozen", "Frozen: 10 of 10 arms.");
      await says(ada, "mine-arm", "Frozen by the teacher.");
      await look(teacher, "after-kill");
      await teacher.getByTestId("class-free").click();
      await teacher.getByTestId("class-frozen").waitFor({ state: "detached" });
      // An action on all arms asks only once.
      await teacher.getByTestId("class-clear-all").click();
      await teacher.getByTestId("confirm").getByText("all 10 arms").waitFor();
      await teacher.getByTestId("confirm-yes").click();
      await says(teacher, "notice", "Done on 10 arms.");
      // The earlier turns ended with the station. A reload does not affect the new ones.
      for (const page of [ada, ben]) {
        await page.getByTestId("join-arm").selectOption("a1");
        await page.getByTestId("turn").click();
      }
      await says(ben, "mine-place", "Place 1");
      await ada.reload();
      await says(ada, "mine-arm", "a1");
      // The teacher passes the turn on, and ends it.
      await teacher.getByTestId("tile-next-a1").click();
      await says(ben, "mine-arm", "a1");
      await says(ada, "mine-place", "Place 1");
      await teacher.getByTestId("tile-home-a1").click();
      await says(ben, "mine-arm", "a1");
      await teacher.getByTestId("tile-clear-a1").click();
      // Ben draws, and the teacher sees it.
      await ben.goto(`${station.url}#/draw`);
      await ben.getByTestId("draw-text").fill("Ben");
      await ben.locator("[data-testid=draw-preview][data-shown=true]").waitFor();
      await look(ben, "draw-tablet");
      await ben.getByTestId("draw-start").click();
      await waitForState(ben, "job", "done", 60_000);
      await teacher.getByTestId("results").locator("img").waitFor();
      assert.ok(
        await teacher
          .getByTestId("results")
          .locator("img")
          .evaluate((image) => image.decode().then(() => image.naturalWidth > 0)),
      );
      await teacher.getByTestId("results").getByText("Ben").first().waitFor();
      await look(teacher, "results");
      await ben.goto(`${station.url}#/class`);
      await teacher.getByTestId("tile-end-a1").click();
      await says(ben, "mine-arm", "You have no arm now.");
      // A new code closes the page with the old one and tells its user.
      await teacher.getByTestId("class-renew-Ben").click();
      await teacher.getByTestId("confirm-yes").click();
      await says(ben, "closed", "Your code is not good any more");
      await look(ben, "closed-tablet");
      await ben.getByTestId("closed-signin").click();
      await ben.getByTestId("class-code").waitFor();
      // A user who takes control is asked for a name once.
      await teacher.getByTestId("arm-a5").getByRole("link").click();
      await waitForState(teacher, "route", "move");
      await teacher.getByTestId("lease-take").click();
      await teacher.getByTestId("naming-name").fill("Ms Lee");
      await look(teacher, "naming", { whole: false });
      await teacher.getByTestId("naming-take").click();
      await waitForState(teacher, "lease", "mine");
      await says(teacher, "owner", "Ms Lee, teacher");
      await teacher.getByTestId("lease-release").click();
      await teacher.getByTestId("lease-take").click();
      await waitForState(teacher, "lease", "mine");
      await teacher.getByTestId("lease-release").click();
      await teacher.goto(`${station.url}#/class`);
      // After a sign-out the sign-in form is empty.
      await chen.getByTestId("class-signout").click();
      await chen.getByTestId("class-code").waitFor();
      assert.equal(await chen.getByTestId("class-code").inputValue(), "");
      // The end of the class signs pupils out and leaves the teacher signed in.
      await teacher.getByTestId("class-end").click();
      await teacher.getByTestId("confirm-yes").click();
      await teacher.getByTestId("class-make").waitFor();
      await says(ada, "closed", "Your code is not good any more");
      await look(ada, "ended-phone");
    } finally {
      for (const context of browser.browser.contexts()) await context.close();
      await station.end();
    }
  });

  test("a hidden page releases its connection after a minute, unless it has a place in the queue", async () => {
    const station = new At(program, ["--arm", "left=sim"]);
    await station.start();
    try {
      const { pin, pupils } = await station.call("class.set", { names: ["Ada", "Ben", "Chen"], turn_s: 600 });
      station.pin = pin;
      const here = async () =>
        (await station.call("class.get")).pupils.filter((pupil) => pupil.here).map(({ name }) => name);
      const pages = {};
      for (const { name, code } of pupils) {
        const page = await browser.page(`${station.url}#/class?${new URLSearchParams({ name, code })}`, {
          ...TABLET,
          clock: true,
        });
        await page.getByTestId("class-signin").click();
        await page.getByTestId("mine-arm").getByText("You have no arm now.").waitFor();
        pages[name] = page;
      }
      await pages.Ben.getByTestId("turn").click();
      await pages.Ben.getByTestId("mine-arm")
        .getByText(/\d left/)
        .waitFor();
      await pages.Chen.getByTestId("turn").click();
      await pages.Chen.getByTestId("mine-place").getByText("Place 1").waitFor();
      assert.deepEqual(await here(), ["Ada", "Ben", "Chen"]);
      for (const page of Object.values(pages)) {
        await hide(page, true);
        await page.clock.fastForward(61_000);
      }
      await waitForState(pages.Ada, "link", "closed");
      for (let looks = 0; (await here()).length > 2 && looks < 100; looks++) await pages.Ada.waitForTimeout(50);
      assert.deepEqual(await here(), ["Ben", "Chen"]);
      for (const page of Object.values(pages)) await hide(page, false);
      await waitForState(pages.Ada, "link", "up");
      await pages.Ada.getByTestId("mine-arm").getByText("You have no arm now.").waitFor();
      assert.deepEqual(await here(), ["Ada", "Ben", "Chen"]);
    } finally {
      for (const context of browser.browser.contexts()) await context.close();
      await station.end();
    }
  });

  test("a full station says so, and lets the page in when there is room", async () => {
    const station = new At(program, ["--arm", "left=sim"]);
    await station.start();
    try {
      const crowd = await (await browser.browser.newContext()).newPage();
      await crowd.goto(`${station.url}healthz`);
      const opened = await crowd.evaluate(
        async (address) => {
          const sockets = Array.from({ length: 150 }, () => new WebSocket(address, "magician.v1"));
          window.sockets = sockets;
          const hello = JSON.stringify({
            jsonrpc: "2.0",
            id: 1,
            method: "session.hello",
            params: { client: { name: "crowd" } },
          });
          return Promise.all(
            sockets.map(
              (socket) =>
                new Promise((done) => {
                  socket.onopen = () => socket.send(hello);
                  socket.onmessage = () => done("in");
                  socket.onclose = ({ code }) => done(code);
                }),
            ),
          );
        },
        `${station.url.replace("http", "ws")}api/v1/ws`,
      );
      assert.ok(opened.includes("in") && opened.includes(4503), `${opened}`);
      const page = await browser.page(`${station.url}#/arms`, { ...TABLET, clock: true });
      await page.getByTestId("closed").getByText("The station is full").waitFor();
      assert.deepEqual(await findings(page), []);
      await page.screenshot({ path: join(shots, "lesson-full.png") });
      await crowd.context().close();
      const isUp = () => page.evaluate(() => document.body.dataset.link === "up");
      for (let looks = 0; looks < 50 && !(await isUp()); looks++) {
        await page.clock.fastForward(25_000);
        await page.waitForTimeout(100);
      }
      await waitForState(page, "link", "up");
      assert.equal(await page.getByTestId("closed").count(), 0);
    } finally {
      for (const context of browser.browser.contexts()) await context.close();
      await station.end();
    }
  });

  test("the schedule is shown at its arm, and nobody gets a useless place in the queue", async () => {
    const station = new At(program, ["--arm", "left=sim", "--arm", "right=sim"]);
    await station.start();
    try {
      const { pin, pupils } = await station.call("class.set", { names: ["Ada", "Ben"], turn_s: 600 });
      station.pin = pin;
      // `left` is reserved for Ben for days; Ada's slot there is tomorrow. `right` is the
      // teacher's.
      const at = (hours) => new Date(Date.now() + hours * 3_600_000).toISOString().replace(/\.\d+/, "");
      const slot = (arms, who, from, until) =>
        `[[slot]]\narms = ["${arms}"]\nwho = ["${who}"]\nfrom = ${at(from)}\nuntil = ${at(until)}\n`;
      await station.call("schedule.set", {
        text: slot("left", "Ben", -1, 20) + slot("left", "Ada", 20, 24) + slot("right", "teacher", -1, 24 * 8),
      });
      const [{ name, code }] = pupils;
      const ada = await browser.page(`${station.url}#/class?${new URLSearchParams({ name, code })}`, PHONE);
      await ada.getByTestId("class-signin").click();
      await ada.getByTestId("join-arm").selectOption("right");
      await ada.getByTestId("turn").click();
      await ada
        .getByTestId("notice")
        .getByText(/right is for teacher until .*ask the teacher/)
        .waitFor();
      assert.deepEqual((await station.call("turn.list")).queue, []);
      await ada.getByTestId("join-arm").selectOption("left");
      await ada.getByTestId("turn").click();
      await ada
        .getByTestId("mine-place")
        .getByText(/The arm is for others by the schedule, until .*\d:\d\d/)
        .waitFor();
      await ada.screenshot({ path: join(shots, "lesson-schedule-phone.png") });
      assert.deepEqual(await findings(ada), []);
      const teacher = await browser.page(`${station.url}#/class`, TABLET);
      await teacher.getByTestId("class-teacher").click();
      await teacher.getByTestId("class-pin").fill(pin);
      await teacher.getByTestId("class-pin-signin").click();
      await teacher
        .getByTestId("slot-left")
        .getByText(/Ben until .*\d:\d\d/)
        .waitFor();
      await teacher
        .getByTestId("slot-right")
        .getByText(/teacher until/)
        .waitFor();
      await teacher
        .getByTestId("pupil-Ada")
        .getByText(/Place 1 in the queue. The arm is for others/)
        .waitFor();
      await teacher.screenshot({ path: join(shots, "lesson-schedule-tablet.png"), fullPage: true });
      assert.deepEqual(await findings(teacher), []);
    } finally {
      for (const context of browser.browser.contexts()) await context.close();
      await station.end();
    }
  });
}
