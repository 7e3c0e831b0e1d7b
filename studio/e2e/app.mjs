// Tests of the studio in a separate window, which is all that its user sees of the program, and of
// the code that admits a tablet.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { once } from "node:events";
import { chmodSync, existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { networkInterfaces, tmpdir } from "node:os";
import { delimiter, join } from "node:path";
import { setTimeout as sleep } from "node:timers/promises";
import { Station, waitForState } from "./bench.mjs";

/** Starts `magician studio --app` with a fake browser that only records its arguments. */
async function started(program, ...words) {
  const home = mkdtempSync(join(tmpdir(), "studio-app-"));
  const asked = join(home, "asked");
  writeFileSync(join(home, "chromium"), `#!/bin/sh\necho "$@" >'${asked}.part' && mv '${asked}.part' '${asked}'\n`);
  chmodSync(join(home, "chromium"), 0o755);
  const env = { ...process.env, XDG_STATE_HOME: home, XDG_CONFIG_HOME: home, XDG_DATA_HOME: home, MAGICIAN_PORT: "" };
  env.PATH = `${home}${delimiter}${process.env.PATH}`;
  const child = spawn(program, ["studio", "--app", "--port", "sim", "--listen", "127.0.0.1:0", ...words], {
    env,
    stdio: "ignore",
  });
  const over = once(child, "exit");
  for (let tries = 0; !existsSync(asked) && tries < 200; tries++) await sleep(50);
  const url = readFileSync(asked, "utf8").match(/--app=(\S+)/)[1];
  const end = () => {
    child.kill();
    rmSync(home, { recursive: true, force: true });
  };
  return { url, over, end };
}

export function app(test, { browser, program }) {
  test("the station of a window ends when the window is closed, not when it is reloaded", async () => {
    const studio = await started(program);
    const page = await browser.connected(studio.url);
    await page.reload();
    await waitForState(page, "link", "up");
    const ended = Promise.race([studio.over, sleep(30_000, ["late"])]);
    const closed = Date.now();
    await page.context().close();
    assert.deepEqual((await ended)[0], 0);
    assert.ok(Date.now() - closed > 5000, "a page that is loaded again would find nothing");
    studio.end();
  });

  test("closing the window asks for confirmation during a motion", async () => {
    const studio = await started(program);
    const page = await browser.inControl(studio.url);
    const asked = [];
    page.on("dialog", (dialog) => {
      asked.push(dialog.type());
      void dialog.dismiss();
    });
    await page.getByTestId("home").click();
    await waitForState(page, "moving", "true");
    await page.close({ runBeforeUnload: true });
    for (let tries = 0; asked.length === 0 && tries < 100; tries++) await sleep(50);
    assert.deepEqual(asked, ["beforeunload"]);
    assert.equal(page.isClosed(), false);
    await page.getByTestId("stop").click();
    await waitForState(page, "moving", "false");
    await page.context().close();
    studio.end();
  });

  test("a tablet signs in with a code of six digits", async () => {
    const addresses = Object.values(networkInterfaces()).flat();
    const own = addresses.find(({ family, internal }) => family === "IPv4" && !internal);
    if (own === undefined) return console.log("      no network: not tried");
    const station = new Station(program);
    station.listen = `${own.address}:0`;
    await station.start("--no-announce");
    try {
      const paired = spawn(program, ["station", "pair"], { env: station.env, stdio: ["ignore", "pipe", "inherit"] });
      const [said] = await once(paired.stdout, "data");
      const code = String(said).match(/\d{6}/)[0];
      const page = await browser.page(`${station.url}#/arms`);
      await page.getByText("The server needs a valid token.").waitFor();
      await page.getByTestId("station-token").fill(code);
      await page.getByTestId("connect-station").click();
      await waitForState(page, "link", "up");
      assert.equal((await page.getByTestId("station-token").inputValue()).length > 30, true);
      await page.context().close();
    } finally {
      await station.end();
    }
  });
}
