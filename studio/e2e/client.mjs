// Test of the page in docs/guide/STATION-CLIENTS.md, served from elsewhere, as written by a user who
// knows only the API.
import assert from "node:assert/strict";
import { once } from "node:events";
import { readFileSync } from "node:fs";
import { createServer } from "node:http";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { Station } from "./bench.mjs";

const DOCS = join(dirname(fileURLToPath(import.meta.url)), "../../docs/guide/STATION-CLIENTS.md");
/** Longer than a lease lives without an answer to a ping, ms. */
const IDLE = 6000;

export function client(test, { browser, program }) {
  test("the page of the documents jogs, runs a program and stops", async () => {
    const text = /^```html\n(.*?)^```$/ms.exec(readFileSync(DOCS, "utf8"))[1];
    const files = createServer((_, answer) => answer.setHeader("content-type", "text/html").end(text)).listen(
      0,
      "127.0.0.1",
    );
    await once(files, "listening");
    const origin = `http://127.0.0.1:${files.address().port}`;
    const station = new Station(program);
    await station.start("--allow-origin", origin);
    const context = await browser.browser.newContext();
    try {
      const page = await context.newPage();
      const problems = [];
      page.on("pageerror", (error) => problems.push(String(error)));
      await page.goto(`${origin}/station.html?${station.url.replace("http", "ws")}api/v1/ws`);
      const says = (words) =>
        page.waitForFunction((words) => document.getElementById("log").textContent.includes(words), words, {
          timeout: 20_000,
        });
      await says("hello teacher");
      await page.waitForFunction(() => document.getElementById("state").textContent.startsWith("up x "));
      await page.click("#take");
      await says("control: page");
      await page.waitForTimeout(IDLE);
      const before = await station.pose();
      assert.equal(before.holder?.name, "page");
      await page.hover("#up");
      await page.mouse.down();
      await page.waitForTimeout(1000);
      assert.notEqual((await station.pose()).jog, null, "it is kept up");
      await page.mouse.up();
      await says("jog ended: released");
      assert.ok((await station.waitForRest()).z > before.z + 1);
      await page.click("#run");
      await says("job done");
      await page.click("#stop");
      await says("stop true");
      assert.deepEqual(problems, []);
    } finally {
      await context.close();
      await station.end();
      files.close();
    }
  });
}
