// A browser without a screen and without a network.

import { chromium } from "playwright-core";
import { mkdirSync } from "node:fs";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";

const FLAGS = [
  "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
  "--disable-component-update", "--disable-sync",
  // WebGL computed by the CPU
  "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
];

export const SIZES = { desktop: { width: 1280, height: 860 }, phone: { width: 390, height: 844 } };
export const SHOTS = "out/browser";

export const start = () => chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: FLAGS });

/** Opens a file; gives the page, with what the browser complained about and what it wanted from a network. */
export async function open(browser, file, { size = "desktop", scheme = "light", ...more } = {}) {
  const context = await browser.newContext({
    viewport: SIZES[size], colorScheme: scheme, hasTouch: size === "phone", isMobile: size === "phone",
    deviceScaleFactor: size === "phone" ? 2 : 1, offline: true, acceptDownloads: true, ...more,
  });
  const page = await context.newPage();
  const complaints = [], requests = [];
  page.on("console", (message) => message.type() === "error" && complaints.push(message.text()));
  page.on("pageerror", (error) => complaints.push(error.message));
  page.on("dialog", (dialog) => { complaints.push(`dialog: ${dialog.message()}`); dialog.dismiss(); });
  page.on("request", (request) => requests.push(request.url()));
  await page.goto(pathToFileURL(resolve(file)).href);
  await drawn(page);
  return { page, complaints, requests, close: () => context.close() };
}

/** Waits until what was asked for is on the screen. */
export const drawn = (page) =>
  page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 30)))));

export async function screenshot(page, name, options = {}) {
  mkdirSync(SHOTS, { recursive: true });
  await page.screenshot({ path: `${SHOTS}/${name}.png`, ...options });
}
