// Test of the example page in docs/guide/STATION-CLIENTS.md, which uses only the API. The page
// comes from another server than the station's.
import assert from "node:assert/strict";
import { once } from "node:events";
import { readFileSync } from "node:fs";
import { createServer } from "node:http";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { Station } from "./bench.mjs";

const DOCS = join(dirname(fileURLToPath(import.meta.url)), "../../docs/guide/STATION-CLIENTS.md");
/** Longer than the timeout of a lease, ms: replies to pings must keep it. */
const IDLE_TIME = 6000;

export function client(test, { browser, program }) {
  test("the page of the documents jogs, runs a program and stops", async () => {
    const text = /^```html\n(.*?)^```$/ms.exec(readFileSync(DOCS, "utf8"))[1];
    const server = createServer((_, answer) => answer.setHeader("content-type", "text/html").end(text)).listen(
      0,
      "127.0.0.1",
    );
    await once(server, "listening");
    const origin = `http://127.0.0.1:${server.address().port}`;
    const station = new Station(program);
    await station.start("--allow-origin", origin);
    const context = await browser.browser.newContext();
    try {
      const page = await context.newPage();
      const problems = [];
      page.on("pageerror", (error) => problems.push(String(error)));
      await page.goto(`${origin}/station.html?${station.url.replace("http", "ws")}api/v1/ws`);
      const waitForLog = (words) =>
        page.waitForFunction((words) => document.getElementById("log").textContent.includes(words), words, {
          timeout: 20_000,
        });
      await waitForLog("hello teacher");
      await page.waitForFunction(() => document.getElementById("state").textContent.startsWith("up x "));
      await page.click("#take");
      await waitForLog("control: page");
      await page.waitForTimeout(IDLE_TIME);
      const before = await station.pose();
      assert.equal(before.holder?.name, "page");
      await page.hover("#up");
      await page.mouse.down();
      await page.waitForTimeout(1000);
      assert.notEqual((await station.pose()).jog, null, "it is kept up");
      await page.mouse.up();
      await waitForLog("jog ended: released");
      assert.ok((await station.waitForRest()).z > before.z + 1);
      await page.click("#run");
      await waitForLog("job done");
      await page.click("#stop");
      await waitForLog("stop true");
      assert.deepEqual(problems, []);
    } finally {
      await context.close();
      await station.end();
      server.close();
    }
  });
}
