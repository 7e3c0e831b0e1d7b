// Records the animation of the README: node e2e/film.mjs [FILE.gif]. Needs ffmpeg.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { mkdtempSync, rmSync, statSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { setTimeout as sleep } from "node:timers/promises";
import { fileURLToPath } from "node:url";
import { Browser, Station, waitForState } from "./bench.mjs";

const root = join(dirname(fileURLToPath(import.meta.url)), "../..");
const out = process.argv[2] ?? join(root, "docs/pictures/studio.gif");
/** Frames per second, frames of a still, and largest size of the file, bytes. */
const [FRAMES_PER_SECOND, STILL_FRAMES, MAX_BYTES] = [6, 8, 2_000_000];

const station = new Station(process.env.MAGICIAN ?? join(root, "target/debug/magician"), ["--port", "sim:4"]);
const browser = new Browser();
const folder = mkdtempSync(join(tmpdir(), "film-"));
let taken = 0;
await browser.start();
await station.start();
const { scenarios } = await station.call("world.scenarios");
await station.call("world.scenario", { text: scenarios.find(({ name }) => name === "drawing").text });
const page = await browser.inControl(station.url, { viewport: { width: 1280, height: 860 }, colorScheme: "light" });
const shot = () => page.screenshot({ path: join(folder, `${String(taken++).padStart(4, "0")}.png`) });
const still = async () => {
  for (let left = STILL_FRAMES; left > 0; left--) await shot();
};
await page.getByTestId("clear-alarms").click();
await waitForState(page, "alarm", "false");
await page.goto(`${station.url}#/run`);
await waitForState(page, "route", "run");
await page.getByTestId("program-open").setInputFiles(join(root, "crates/magician-program/samples/house.svg"));
await page.locator("[data-testid=run-preview][data-shown=true]").waitFor();
await still();
await page.getByTestId("run-start").click();
await waitForState(page, "job", "running");
while ((await page.evaluate(() => document.body.dataset.job)) === "running") {
  await shot();
  await sleep(1000 / FRAMES_PER_SECOND / 2);
}
await waitForState(page, "job", "done");
await still();
await page.goto(`${station.url}#/world`);
await waitForState(page, "route", "world");
await page.getByTestId("world-paper").scrollIntoViewIfNeeded();
await sleep(1000);
await still();
await browser.end();
await station.end();
const ffmpegArgs = [
  "-y",
  "-loglevel",
  "error",
  "-framerate",
  String(FRAMES_PER_SECOND),
  "-i",
  join(folder, "%04d.png"),
  "-vf",
  "scale=860:-1:flags=lanczos,split[a][b];[a]palettegen=max_colors=96:stats_mode=diff[p];[b][p]paletteuse=dither=none:diff_mode=rectangle",
  out,
];
assert.equal(spawnSync("ffmpeg", ffmpegArgs, { stdio: "inherit" }).status, 0, "ffmpeg makes the recording");
rmSync(folder, { recursive: true });
const { size } = statSync(out);
console.log(`${out}: ${taken} pictures, ${size} bytes`);
assert.ok(size < MAX_BYTES, `${size} bytes of ${MAX_BYTES}`);
