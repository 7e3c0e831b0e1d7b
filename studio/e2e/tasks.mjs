// Whole tasks for users who do not see the page or have no mouse: only by role and name, and only
// by keyboard.
import assert from "node:assert/strict";
import { near, waitForState } from "./bench.mjs";

const SQUARE =
  '<svg xmlns="http://www.w3.org/2000/svg" width="30mm" height="30mm" viewBox="0 0 30 30"><path d="M0 0H30V30H0Z" fill="none" stroke="#000"/></svg>';
const FILE = { name: "task.svg", mimeType: "image/svg+xml", buffer: Buffer.from(SQUARE) };

/** User who finds elements by role and name, and presses them. */
class Pointer {
  constructor(page) {
    this.page = page;
  }

  found(role, name) {
    return this.page.getByRole(role, { name, exact: true });
  }

  press(role, name) {
    return this.found(role, name).click();
  }

  choose(name, option) {
    return this.found("combobox", name).selectOption({ label: option });
  }

  async radio(name) {
    await this.found("radio", name).check({ force: true });
  }

  async type(role, name, text) {
    await this.found(role, name).fill(text);
    await this.found(role, name).press("Tab");
  }

  async open(name, file) {
    const [chooser] = await Promise.all([this.page.waitForEvent("filechooser"), this.press("button", name)]);
    await chooser.setFiles(file);
  }
}

/** User with a keyboard: Tab to an element, and the keys that operate it. */
class Keyboard extends Pointer {
  async go(role, name) {
    const wanted = this.found(role, name).and(this.page.locator(":focus"));
    for (let presses = 0; presses < 250; presses++) {
      if ((await wanted.count()) > 0) return;
      await this.page.keyboard.press("Tab");
    }
    throw new Error(`Tab does not come to the ${role} ${name}`);
  }

  async press(role, name) {
    // A disabled element cannot be reached, so it is waited for, as a user does.
    await this.page.waitForFunction((element) => !element.disabled, await this.found(role, name).elementHandle());
    await this.go(role, name);
    await this.page.keyboard.press("Enter");
  }

  async choose(name, option) {
    await this.go("combobox", name);
    await this.page.keyboard.type(option);
  }

  /** In a group the selected element has the focus, and arrows move on. */
  async radio(name) {
    const wanted = this.found("radio", name);
    for (let presses = 0; presses < 250 && !(await wanted.isChecked()); presses++) {
      const inGroup = await wanted.evaluate(
        (radio) => document.activeElement?.name === radio.name && document.activeElement.type === "radio",
      );
      await this.page.keyboard.press(inGroup ? "ArrowRight" : "Tab");
    }
    assert.ok(await wanted.isChecked(), name);
  }

  async type(role, name, text) {
    await this.go(role, name);
    await this.page.keyboard.press("Control+A");
    await this.page.keyboard.type(text);
    await this.page.keyboard.press("Tab");
  }
}

export function tasks(test, { browser, station, closePage }) {
  const job = async () => (await station.call("job.list")).jobs.at(-1);

  async function all(page, hand) {
    const to = async (link, route) => {
      await hand.press("link", link);
      await waitForState(page, "route", route);
    };
    // Connects to a server by its address, and takes control.
    await to("Arms", "arms");
    await hand.press("button", "Disconnect");
    await waitForState(page, "backend", "none");
    await hand.type("textbox", "Address", new URL(station.url).host);
    await hand.press("button", "Server");
    await waitForState(page, "link", "up");
    await hand.press("button", "Take control");
    await waitForState(page, "lease", "mine");

    // Clears alarms, homes, and moves one step up.
    await to("Move", "move");
    await hand.press("button", "Clear alarms");
    await waitForState(page, "alarm", "false");
    await hand.press("button", "Home");
    await waitForState(page, "moving", "true");
    await waitForState(page, "moving", "false", 40_000);
    await hand.radio("Step");
    await hand.choose("Step size", "10 mm or °");
    const { z } = await station.waitForRest();
    await hand.press("button", "Jog Z plus");
    await station.until("a step up", (state) => near(state.z, z + 10) && !state.moving);

    // Adds two points, and plays both.
    await to("Teach", "teach");
    await hand.press("button", "Add point");
    await hand
      .found("row", /P1/)
      .or(page.getByRole("table", { name: "Points" }).getByRole("row").nth(1))
      .first()
      .waitFor();
    await hand.press("button", "Jog Y plus");
    const there = await station.until(
      "a step to the left",
      (state) => !state.moving && near(state.z, z + 10) && state.y > 5,
    );
    await hand.press("button", "Add point");
    await page.getByRole("checkbox", { name: "Select point 2" }).waitFor();
    await hand.press("button", "Play all");
    await waitForState(page, "job", "running");
    await waitForState(page, "job", "done", 30_000);
    assert.ok(near((await station.waitForRest()).y, there.y));

    // Opens, checks, starts and stops a program.
    await to("Run", "run");
    await hand.open("Open a file", FILE);
    await page.getByRole("button", { name: "task.svg", pressed: true }).waitFor();
    await hand.press("button", "Check");
    await page.getByRole("status").filter({ hasText: "The arm can do it" }).waitFor();
    await hand.press("button", "Start");
    await waitForState(page, "job", "running");
    await page.getByRole("progressbar", { name: "Job progress" }).waitFor();
    await hand.press("button", "Stop job");
    await waitForState(page, "job", "stopped");
    assert.equal((await job()).title, "task");

    // Reads and clears an alarm.
    await to("World", "world");
    await hand.press("button", "Raise alarm");
    await page.getByRole("alert").filter({ hasText: "What to do" }).waitFor();
    await to("Move", "move");
    await hand.press("button", "Clear alarms");
    await waitForState(page, "alarm", "false");

    // Sets a pin.
    await to("Pins", "io");
    await hand.choose("Function of pin 2", "Digital output");
    await page.getByRole("button", { name: "Set pin 2" }).waitFor();
    await hand.press("button", "Set pin 2");
    await page.getByRole("button", { name: "Set pin 2", pressed: true }).waitFor();
    assert.equal((await station.call("arm.io")).pins[1].level, 1);
    await hand.choose("Function of pin 2", "None");
    await page.getByRole("button", { name: "Set pin 2" }).waitFor({ state: "detached" });

    // Switches the language and back.
    await to("Settings", "settings");
    await hand.radio("中文");
    await page.getByRole("button", { name: "停止", exact: true }).waitFor();
    await hand.radio("English");
    await hand.press("button", "Stop");
    await page.getByRole("status").filter({ hasText: "The arm has stopped" }).waitFor();
    await station.call("program.delete", { name: FILE.name });
    await closePage(page);
  }

  test("complete tasks by role and name alone", async () => {
    const page = await browser.connected(station.url);
    await all(page, new Pointer(page));
  });

  test("complete tasks by keyboard alone", async () => {
    const page = await browser.connected(station.url);
    await all(page, new Keyboard(page));
  });
}
