// Makes the picture of a notebook from the page that python/notebooks/picture.py writes: its last cell that shows a recording.

import { statSync, writeFileSync } from "node:fs";
import { drawn, open, start } from "./browser.mjs";
import { picture } from "./png.mjs";

const PATH = "assets/gallery/notebook.png", MOST_BYTES = 100_000;
/** Moment of the recording, s. */
const TIME = 0.35;
/** Room about the cell, pixels. */
const MARGIN = 6;

const browser = await start();
const { page, close } = await open(browser, "out/notebook/index.html", { viewport: { width: 820, height: 900 } });
const shows = page.locator(".jp-Cell", { has: page.locator("iframe") }).last();
await shows.scrollIntoViewIfNeeded();
const frame = await (await shows.locator("iframe").elementHandle()).contentFrame();
await frame.waitForFunction(() => window.dualbody?.player);
await frame.evaluate((time) => window.dualbody.player.seek(time), TIME);
await drawn(page);
const box = await shows.boundingBox();
const clip = { x: Math.floor(box.x) + MARGIN, y: Math.floor(box.y), width: Math.floor(box.width) - 2 * MARGIN, height: Math.floor(box.height) };
writeFileSync(PATH, await picture(page, clip));
const { size } = statSync(PATH);
console.log(`${PATH}: ${size} bytes`);
if (size > MOST_BYTES) throw new Error(`${PATH} is larger than ${MOST_BYTES} bytes`);
await close();
await browser.close();
