// A simulation that runs, used as a person would: by the program `dualbody`, whose path is in DUALBODY.

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { after, before, test } from "node:test";
import { drawn, screenshot, start } from "./browser.mjs";

let browser;
before(async () => { browser = await start(); });
after(() => browser.close());

/** Runs a simulation and opens its page; hands both to a test, and ends them. */
async function on(words, use) {
  const program = spawn(process.env.DUALBODY, ["live", "--no-open", ...words], { stdio: ["ignore", "pipe", "inherit"] });
  const url = await new Promise((done, fail) => {
    program.stdout.once("data", (text) => done(String(text).trim()));
    program.once("exit", (code) => fail(new Error(`the program ended with ${code}`)));
  });
  const page = await browser.newPage({ viewport: { width: 1280, height: 860 } });
  const complaints = [], requests = [];
  page.on("console", (message) => message.type() === "error" && complaints.push(message.text()));
  page.on("pageerror", (error) => complaints.push(error.message));
  page.on("request", (request) => requests.push(request.url()));
  try {
    await page.goto(url);
    await page.waitForFunction(() => window.dualbody?.live?.frames > 2);
    await use(page, { url, program });
    assert.deepEqual(complaints, []);
    assert.ok(requests.every((request) => request.startsWith(url) || request.startsWith("blob:")), String(requests));
  } finally {
    await page.close();
    program.kill();
  }
}

const state = (page) => page.evaluate(() => {
  const { frame } = window.dualbody.live;
  return { time: frame.time, paused: frame.paused, poses: frame.poses, drag: frame.drag, contacts: frame.contacts, factor: frame.factor };
});
/** Waits until frames of now have come. */
const fresh = async (page, count = 6) => {
  const frames = await page.evaluate(() => window.dualbody.live.frames);
  await page.waitForFunction((least) => window.dualbody.live.frames >= least, frames + count);
};
/** Where a point of the world is on the screen. */
const onScreen = (page, point) => page.evaluate((point) => {
  const { camera } = window.dualbody, box = camera.canvas.getBoundingClientRect(), m = camera.view().matrix;
  const at = [...point, 1], row = (k) => at.reduce((sum, x, j) => sum + m[4 * j + k] * x, 0);
  return { x: box.left + ((row(0) / row(3) + 1) / 2) * box.width, y: box.top + ((1 - row(1) / row(3)) / 2) * box.height };
}, point);

const BOX = ["assets/box.urdf", "--terrain", "flat"];

test("time passes, stops, goes by steps, and begins again", () => on(["assets/cartpole.urdf"], async (page) => {
  const first = await state(page);
  await fresh(page, 20);
  assert.ok((await state(page)).time > first.time + 0.1);
  await page.click("#play");
  await page.waitForFunction(() => window.dualbody.live.frame.paused);
  const stopped = (await state(page)).time;
  await fresh(page);
  assert.equal((await state(page)).time, stopped);
  await page.click("#step");
  await fresh(page);
  assert.ok(Math.abs((await state(page)).time - stopped - 0.001) < 1e-9);
  await page.click("#reset");
  await fresh(page);
  assert.equal((await state(page)).time, 0);
  await page.locator("#view").focus();
  await page.keyboard.press("Space");
  await page.waitForFunction(() => window.dualbody.live.frame.time > 0.05);
}));

test("time passes as fast as it is asked to", () => on(["assets/cartpole.urdf"], async (page) => {
  const rate = async (speed) => {
    await page.selectOption("#speed", String(speed));
    await fresh(page, 10);
    const [a, begin] = [(await state(page)).time, Date.now()];
    await page.waitForTimeout(1500);
    return ((await state(page)).time - a) / ((Date.now() - begin) / 1000);
  };
  const slow = await rate(0.25);
  assert.ok(slow > 0.15 && slow < 0.3, `${slow} in place of 0.25`);
}));

test("a box that is dragged by the mouse follows it and falls when it is let go", () => on(BOX, async (page) => {
  await fresh(page, 20);
  const rest = (await state(page)).poses[0];
  assert.ok((await state(page)).contacts.length > 0, "it stands on the ground");
  const from = await onScreen(page, rest.slice(0, 3));
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  await page.mouse.move(from.x, from.y - 160, { steps: 8 });
  await page.waitForFunction((z) => window.dualbody.live.frame.poses[0][2] > z, rest[2] + 0.05, { timeout: 20000 });
  const held = await state(page);
  assert.ok(held.drag !== null && held.drag[5] > held.drag[2] - 0.5);
  await screenshot(page, "live-drag");
  await page.mouse.up();
  await page.waitForFunction((z) => window.dualbody.live.frame.drag === null && window.dualbody.live.frame.poses[0][2] < z, rest[2] + 0.02, { timeout: 20000 });
}));

test("dragging beside the robot turns the camera only", () => on(BOX, async (page) => {
  const before = await page.evaluate(() => window.dualbody.camera.azimuth);
  const box = await page.locator("#view").boundingBox();
  await page.mouse.move(box.x + 8, box.y + 8);
  await page.mouse.down();
  await page.mouse.move(box.x + 90, box.y + 8, { steps: 4 });
  await page.mouse.up();
  assert.notEqual(await page.evaluate(() => window.dualbody.camera.azimuth), before);
  assert.equal((await state(page)).drag, null);
}));

test("a slider moves its joint to its target", () => on(["assets/cartpole.urdf"], async (page) => {
  const slider = page.locator("#panel input[type=range]").first();
  await slider.evaluate((input) => { input.value = 0.5; input.dispatchEvent(new Event("input")); });
  // The cart runs along y.
  await page.waitForFunction(() => window.dualbody.live.frame.poses.some((pose) => Math.abs(pose[1] - 0.5) < 0.05), null, { timeout: 20000 });
}));

test("what was seen is saved", () => on(["assets/cartpole.urdf"], async (page) => {
  await fresh(page, 20);
  for (const format of ["csv", "html", "json"]) {
    const [download] = await Promise.all([page.waitForEvent("download"), page.click(`#save a[download$=".${format}"]`)]);
    assert.ok(download.suggestedFilename().endsWith(format));
    assert.equal(await download.failure(), null);
  }
}));

test("a page of another origin is refused", () => on(["assets/cartpole.urdf"], async (page, { url }) => {
  const stranger = await browser.newPage();
  const opened = await stranger.evaluate((url) => new Promise((done) => {
    const socket = new WebSocket(`${url.replace("http", "ws")}socket`);
    socket.onopen = () => done(true);
    socket.onerror = () => done(false);
  }), url);
  assert.equal(opened, false);
  await stranger.close();
}));

test("the page says that the simulation has ended", () => on(["assets/cartpole.urdf"], async (page, { program }) => {
  program.kill();
  await page.waitForFunction(() => document.getElementById("status").textContent.includes("ended"));
  await drawn(page);
}));
