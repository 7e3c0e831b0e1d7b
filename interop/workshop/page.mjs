// Opens a page of the studio that starts an engraving and is then closed: node page.mjs URL FILE
//
// Prints `burns PID` (of the browser) once the station has started the job. Closes the page after a
// line on stdin, and the browser at the end of stdin.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { createInterface } from "node:readline";

const { chromium } = createRequire(new URL("../../studio/package.json", import.meta.url))("playwright-core");
const [url, file] = process.argv.slice(2);
const server = await chromium.launchServer({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: ["--no-sandbox"] });
const browser = await chromium.connect(server.wsEndpoint());
const page = await browser.newPage();
await page.goto(url);
await page.evaluate(async (text) => {
  const socket = new WebSocket(`${location.origin.replace("http", "ws")}/api/v1/ws`);
  await new Promise((done) => socket.addEventListener("open", done));
  let id = 0;
  const call = (method, params) =>
    new Promise((done, failed) => {
      const own = ++id;
      socket.addEventListener("message", ({ data }) => {
        const answer = JSON.parse(data);
        if (answer.id === own) answer.error ? failed(new Error(JSON.stringify(answer.error))) : done(answer.result);
      });
      socket.send(JSON.stringify({ jsonrpc: "2.0", id: own, method, params }));
    });
  await call("session.hello", { client: { name: "page" } });
  await call("lease.acquire", { wait_s: 10 });
  await call("job.start", { text, format: "gcode", setup: { work: "engrave", surface: -50 }, yes: true, unhomed: true });
}, readFileSync(file, "utf8"));
console.log(`burns ${server.process().pid}`);
for await (const line of createInterface({ input: process.stdin })) if (line === "close") await page.close();
await server.kill();
