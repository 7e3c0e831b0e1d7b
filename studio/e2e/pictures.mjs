// Pictures of the gallery: node e2e/pictures.mjs [PART of the names]. Each example runs in the
// page's own virtual arm, and is taken from the page's picture.
import { spawnSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { setTimeout as sleep } from "node:timers/promises";
import { Browser, waitForState } from "./bench.mjs";
import { Files, Sim } from "./sim.mjs";

const root = join(import.meta.dirname, "../..");
const program = process.env.MAGICIAN ?? join(root, "target/debug/magician");
const to = join(root, "studio/public/assets");
const WIDE = 440;

const done = (page) => waitForState(page, "job", "done", 120_000);
const holds = async (_, sim) => {
  for (let tries = 0; tries < 600; tries++) {
    const { objects } = await sim.call("world.look");
    const { z } = await sim.pose();
    if (objects.some(({ held }) => held) && z > 0) return;
    // A session may send 200 messages a second.
    await sleep(50);
  }
  throw new Error("it holds nothing");
};
const passes = (seconds) => (page) => page.waitForTimeout(1000 * seconds);
/** Moment of each picture, and the speed factor until then. */
const MOMENTS = {
  draw: [20, done],
  write: [20, done],
  stamp: [20, done],
  engrave: [20, passes(14)],
  pick: [1, holds],
  stack: [5, done],
  belt: [1, holds],
  teach: [1, passes(2)],
  playback: [1, passes(4)],
  // Before its cable is unplugged.
  faults: [1, passes(0)],
};

const word = process.argv[2] ?? "";
const folder = mkdtempSync(join(tmpdir(), "studio-pictures-"));
spawnSync(program, ["studio", "--export", folder], { stdio: "inherit" });
const files = new Files(folder);
await files.start();
const browser = new Browser();
await browser.start();
try {
  for (const [name, [speed, moment]] of Object.entries(MOMENTS).filter(([name]) => name.includes(word))) {
    const page = await browser.page(`${files.url}?speed=${speed}#/gallery`, { deviceScaleFactor: 2 });
    await page.getByTestId(`gallery-${name}`).click();
    await waitForState(page, "lease", "mine", 30_000);
    const sim = new Sim("none");
    await sim.join(page);
    await page.waitForFunction(() => ["running", "done"].includes(document.body.dataset.job), null, {
      timeout: 60_000,
    });
    await page.evaluate(() => {
      location.hash = "#/move";
    });
    await page.addStyleTag({ content: ".cameras, .zooms, .axis { visibility: hidden !important; }" });
    await page.locator(".view canvas").waitFor();
    await moment(page, sim);
    await page.waitForTimeout(300);
    const { x, y, width, height } = await page.locator(".view canvas").boundingBox();
    // The centre, with the aspect ratio of the gallery's pictures.
    const wide = Math.min(width, height * 1.6);
    const clip = { x: x + (width - wide) / 2, y: y + (height - wide / 1.6) / 2, width: wide, height: wide / 1.6 };
    const shot = (await page.screenshot({ clip })).toString("base64");
    const made = await page.evaluate(
      async ([shot, wide]) => {
        const bytes = Uint8Array.from(atob(shot), (sign) => sign.charCodeAt(0));
        const image = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
        const canvas = new OffscreenCanvas(wide, wide / 1.6);
        const pen = canvas.getContext("2d");
        pen.imageSmoothingQuality = "high";
        pen.drawImage(image, 0, 0, canvas.width, canvas.height);
        const made = await canvas.convertToBlob({ type: "image/webp", quality: 0.8 });
        return [...new Uint8Array(await made.arrayBuffer())];
      },
      [shot, WIDE],
    );
    writeFileSync(join(to, `example-${name}.webp`), Buffer.from(made));
    console.log(`${name}: ${made.length} bytes`);
    await page.context().close();
  }
} finally {
  await browser.end();
  files.end();
  rmSync(folder, { recursive: true, force: true });
}
