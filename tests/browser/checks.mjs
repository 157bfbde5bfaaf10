// What a person does with a page, done by a program. Each test says the two things that it compares.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { after, before, test } from "node:test";
import { contrasts } from "./contrast.mjs";
import { drawn, open, screenshot, start } from "./browser.mjs";

const CARTPOLE = "out/pages/cartpole.html", ROBOT = "out/pages/humanoid.html", HOSTILE = "out/pages/hostile.html";
const BATCH = "out/pages/batch.html", HOUR = "out/pages/hour.html";

let browser;
before(async () => { browser = await start(); });
after(() => browser.close());

/** Runs a test on an open page; in the end nothing may have been complained about or fetched. */
const on = (file, options, name, body) =>
  test(name, async () => {
    const opened = await open(browser, file, options);
    await body(opened.page);
    assert.deepEqual(opened.complaints, [], "the console is silent");
    assert.deepEqual(opened.requests.filter((url) => !/^(file|blob):/.test(url)), [], "nothing is fetched");
    await opened.close();
  });

/** The colours of the canvas: how many there are, and a sum that tells pictures apart. */
const colors = (page) =>
  page.evaluate(() => {
    const canvas = document.getElementById("view"), gl = canvas.getContext("webgl2");
    const { player, scene, camera } = window.dualbody;
    scene.update();
    scene.draw(camera.view(), { background: [1, 1, 1], ground: [0.9, 0.9, 0.9], lines: [0.5, 0.5, 0.5] });
    const pixels = new Uint8Array(canvas.width * canvas.height * 4);
    gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    const words = new Uint32Array(pixels.buffer);
    return { different: new Set(words).size, sum: words.reduce((sum, word, k) => (sum * 31 + word + k) >>> 0, 7), width: canvas.width, time: player?.time };
  });

/** The table of a CSV without quotes: rows of { name: number }. */
function table(file) {
  const [header, ...rows] = readFileSync(file, "utf8").trim().split("\n").map((line) => line.split(","));
  return rows.map((row) => Object.fromEntries(header.map((name, k) => [name, Number(row[k])])));
}

on(CARTPOLE, {}, "canvas while playing differs from the canvas before", async (page) => {
  const before = await colors(page);
  assert.ok(before.different > 50, `${before.different} colours`);
  await page.click("#play");
  await page.waitForTimeout(700);
  await page.click("#play");
  await drawn(page);
  const after = await colors(page);
  assert.ok(after.time > 0.2, `${after.time} s have passed`);
  assert.notEqual(after.sum, before.sum);
});

on(CARTPOLE, {}, "pose of the pole on the page equals the state in the CSV at five times", async (page) => {
  const rows = table("out/pages/cartpole.csv");
  // Five moments that the page has, and one between two of them, where it interpolates.
  for (const [k, tolerance] of [[0, 1e-4], [76, 1e-4], [250, 1e-4], [612, 1e-4], [1000, 1e-4], [77, 2e-3]]) {
    const row = rows[k];
    const [pole, zero] = await page.evaluate((time) => {
      const { player, scene, data } = window.dualbody;
      player.seek(time);
      scene.update();
      return [scene.place(0, 1), scene.still(data.robots[0], {})[1]];
    }, row.time);
    // The angle between the orientations at q = 0 and now: twice that whose sine is half the distance of the quaternions.
    const apart = (sign) => Math.hypot(...[3, 4, 5, 6].map((i) => pole[i] - sign * zero[i]));
    const turned = 4 * Math.asin(Math.min(apart(1), apart(-1)) / 2), angle = Math.abs(row["q.pivot"]) % (2 * Math.PI);
    assert.ok(Math.abs(turned - Math.min(angle, 2 * Math.PI - angle)) < tolerance, `t = ${row.time}: ${turned} against ${angle}`);
    assert.ok(Math.abs(pole[1] - row["q.linear"]) < tolerance, `t = ${row.time}: ${pole[1]} against ${row["q.linear"]}`);
  }
});

on(CARTPOLE, {}, "timeline, plots and keys move to the time that they say", async (page) => {
  const time = () => page.evaluate(() => window.dualbody.player.time);
  const bar = await page.locator("#time").boundingBox();
  await page.mouse.click(bar.x + bar.width / 2, bar.y + bar.height / 2);
  assert.ok(Math.abs((await time()) - 5) < 0.2, `the middle of the timeline is ${await time()} s`);
  const plot = await page.locator("figure canvas").first().boundingBox();
  await page.mouse.click(plot.x + 58 + (plot.width - 68) * 0.2, plot.y + 40);
  assert.ok(Math.abs((await time()) - 2) < 0.05, `a fifth of the plot is ${await time()} s`);
  await page.focus("#view");
  await page.keyboard.press("End");
  assert.equal(await time(), 10);
  await page.keyboard.press("ArrowLeft");
  assert.ok((await time()) < 10 && (await time()) > 9.9);
  await page.keyboard.press("Home");
  assert.equal(await time(), 0);
  await page.keyboard.press("+");
  assert.equal(await page.inputValue("#speed"), "2");
  await page.keyboard.press(" ");
  assert.equal(await page.evaluate(() => window.dualbody.player.playing), true);
  await page.keyboard.press(" ");
  assert.equal(await page.evaluate(() => window.dualbody.player.playing), false);
});

on(CARTPOLE, {}, "value beside a name equals the CSV where the mouse is", async (page) => {
  const plot = await page.locator("figure canvas").first().boundingBox();
  const share = 0.4;
  await page.mouse.move(plot.x + 58 + (plot.width - 68) * share, plot.y + 60);
  await drawn(page);
  const shown = Number(await page.locator("figure .value").first().textContent());
  const row = table("out/pages/cartpole.csv")[1000 * share];
  assert.ok(Math.abs(shown - row["q.linear"]) < 0.01, `${shown} against ${row["q.linear"]}`);
});

on(CARTPOLE, {}, "mouse turns, shifts and zooms the camera", async (page) => {
  const camera = () => page.evaluate(() => { const { lookAt, distance, azimuth, elevation } = window.dualbody.camera; return { lookAt, distance, azimuth, elevation }; });
  const box = await page.locator("#view").boundingBox(), [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  const start = await camera();
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 50, y + 20, { steps: 4 });
  await page.mouse.up();
  const turned = await camera();
  assert.ok(Math.abs(start.azimuth - turned.azimuth - 20) < 1e-6 && Math.abs(turned.elevation - start.elevation - 8) < 1e-6);
  await page.mouse.down({ button: "right" });
  await page.mouse.move(x, y, { steps: 4 });
  await page.mouse.up({ button: "right" });
  const shifted = await camera();
  assert.notDeepEqual(shifted.lookAt, start.lookAt);
  await page.mouse.wheel(0, 300);
  await drawn(page);
  assert.ok((await camera()).distance > shifted.distance);
  await page.click("#fit");
  assert.deepEqual((await camera()).lookAt, start.lookAt);
});

/** Puts fingers on a screen, moves each along its own way in a few steps, and lifts them; a way is a list of two points. */
async function touch(page, ways, steps = 5) {
  const session = await page.context().newCDPSession(page);
  const send = (type, share) => session.send("Input.dispatchTouchEvent", {
    type, touchPoints: type === "touchEnd" ? [] : ways.map(([[a, b], [x, y]], id) => ({ id, x: a + (x - a) * share, y: b + (y - b) * share })),
  });
  await send("touchStart", 0);
  for (let k = 1; k <= steps; k++) await send("touchMove", k / steps);
  await send("touchEnd");
  await drawn(page);
}

on(CARTPOLE, { size: "phone" }, "one finger turns the camera; two zoom by how far they part and shift by how far they go", async (page) => {
  const camera = () => page.evaluate(() => { const { lookAt, distance, azimuth, elevation } = window.dualbody.camera; return { lookAt, distance, azimuth, elevation }; });
  const box = await page.locator("#view").boundingBox(), at = (x, y) => [box.x + box.width / 2 + x, box.y + box.height / 2 + y];
  const start = await camera();
  await touch(page, [[at(0, 0), at(50, 20)]]);
  const turned = await camera();
  assert.ok(Math.abs(start.azimuth - turned.azimuth - 20) < 1e-6 && Math.abs(turned.elevation - start.elevation - 8) < 1e-6);
  assert.equal(turned.distance, start.distance);
  await touch(page, [[at(-40, 0), at(-100, -40)], [at(40, 0), at(100, 40)]]);
  const near = await camera(), parted = 80 / Math.hypot(200, 80);
  assert.ok(Math.abs(near.distance / turned.distance - parted) < 1e-6, `${near.distance / turned.distance} against ${parted}`);
  assert.deepEqual([near.azimuth, near.elevation], [turned.azimuth, turned.elevation], "two fingers do not turn");
  await touch(page, [[at(-100, -40), at(-40, 0)], [at(100, 40), at(40, 0)]]);
  const back = await camera();
  assert.ok(Math.abs(back.distance / turned.distance - 1) < 1e-6, "fingers that come together again undo it");
  await touch(page, [[at(-40, 0), at(0, -30)], [at(40, 0), at(80, -30)]]);
  const shifted = await camera(), went = Math.hypot(...shifted.lookAt.map((x, axis) => x - back.lookAt[axis]));
  // 50 pixels in the plane of the point that is looked at, of which the canvas shows 2 d tan 20° over its height.
  const expected = (50 * 2 * back.distance * Math.tan(Math.PI / 9)) / box.height;
  assert.ok(Math.abs(went / expected - 1) < 0.05, `${went} m against ${expected} m`);
  assert.ok(Math.abs(shifted.distance / back.distance - 1) < 1e-6, "fingers side by side do not zoom");
  assert.equal(await page.evaluate(() => visualViewport.scale), 1, "the page itself does not zoom");
});

on(CARTPOLE, {}, "size of the canvas follows that of the window", async (page) => {
  const wide = await colors(page);
  await page.setViewportSize({ width: 700, height: 800 });
  await drawn(page);
  const narrow = await colors(page);
  assert.ok(narrow.width < wide.width && narrow.width > 600);
  assert.equal(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), true);
});

on(CARTPOLE, {}, "picture and video buttons give files of their kinds", async (page) => {
  const read = async (action) => {
    const [download] = await Promise.all([page.waitForEvent("download"), action()]);
    return { name: download.suggestedFilename(), bytes: readFileSync(await download.path()) };
  };
  const picture = await read(() => page.click("#picture"));
  assert.match(picture.name, /\.png$/);
  assert.equal(picture.bytes.subarray(1, 4).toString(), "PNG");
  await page.click("#play");
  await page.click("#video");
  await page.waitForTimeout(1000);
  const video = await read(() => page.click("#video"));
  assert.match(video.name, /\.webm$/);
  assert.equal(video.bytes.readUInt32BE(0), 0x1a45dfa3, "the mark of Matroska files");
  assert.ok(video.bytes.length > 5000, `${video.bytes.length} bytes`);
});

on(ROBOT, {}, "sliders move bodies to the poses that the library computes", async (page) => {
  const expected = JSON.parse(readFileSync("out/pages/humanoid.json", "utf8"));
  const poses = await page.evaluate((q) => {
    const { panel, scene } = window.dualbody;
    for (const { made, slider } of panel.joints) {
      made.input.value = q[slider.coordinate];
      made.input.dispatchEvent(new Event("input"));
    }
    return scene.poses[0];
  }, expected.q);
  assert.equal(poses.length, expected.poses.length);
  poses.forEach((pose, body) => {
    const same = (sign) => Math.max(...pose.map((x, i) => Math.abs(x - (i < 3 ? 1 : sign) * expected.poses[body][i])));
    assert.ok(Math.min(same(1), same(-1)) < 1e-9, `body ${body}: ${pose} against ${expected.poses[body]}`);
  });
});

on(ROBOT, {}, "switches and the tree change the picture", async (page) => {
  let last = await colors(page);
  for (const key of ["f", "m", "i"]) {
    await page.keyboard.press(key);
    await drawn(page);
    const now = await colors(page);
    assert.notEqual(now.sum, last.sum, key);
    last = now;
  }
  assert.equal(await page.locator(".tree button").count(), await page.evaluate(() => window.dualbody.data.robots[0].links.length));
  const link = page.locator(".tree button").nth(3);
  await link.hover();
  assert.notEqual((await colors(page)).sum, last.sum, "the link is marked");
});

on(HOSTILE, {}, "names with HTML and quotes are shown as text and never run", async (page) => {
  const { title, robots, warnings } = await page.evaluate(() => window.dualbody.data);
  assert.equal(await page.textContent("#title"), title);
  assert.match(title, /<script>/);
  const names = await page.locator(".link").allTextContents();
  assert.deepEqual(names, robots[0].links.map((link) => link.name));
  assert.ok(names.some((name) => name.includes("<img")));
  const lines = await page.locator("figure .name, h3").allTextContents();
  assert.ok(lines.some((name) => name.includes("</script>")));
  assert.ok(warnings.length === 1 && (await page.textContent("#warnings li")) === warnings[0]);
  assert.equal(await page.locator("img, script:not([id]):nth-of-type(3)").count(), 0);
  assert.equal(await page.evaluate(() => window.hacked), undefined);
});

on(HOSTILE, {}, "what stands beside the robot has a switch with its name, shown as text", async (page) => {
  const names = await page.evaluate(() => window.dualbody.data.fixtures.map((fixture) => fixture.name));
  assert.ok(names.length === 2 && names[0].includes("<img"));
  let last = await colors(page);
  for (const name of names) {
    const box = page.locator(".switch", { hasText: name });
    assert.equal(await box.locator("span").textContent(), name);
    await box.locator("input").click();
    await drawn(page);
    const now = await colors(page);
    assert.notEqual(now.sum, last.sum, `without ${name}`);
    last = now;
  }
  const inside = await page.evaluate(() => {
    const { fixtures, bounds } = window.dualbody.scene, [x] = fixtures[0].shapes[0].pose, [radius] = fixtures[0].shapes[0].size;
    return bounds.low[0] <= x - radius && bounds.high[0] >= x + radius;
  });
  assert.ok(inside, "the picture is large enough for it");
});

on(BATCH, {}, "plots of a batch follow the choice of the robot", async (page) => {
  const first = await page.evaluate(() => window.dualbody.motion.robots.map((robot) => robot.plots[0].lines[0].values[0]));
  await page.selectOption("#robot", "2");
  await drawn(page);
  const shown = Number(await page.locator("figure .value").first().textContent());
  assert.ok(Math.abs(shown - first[2]) < 1e-3, `${shown} against ${first[2]}`);
});

on(HOUR, {}, "an hour of motion is drawn at once", async (page) => {
  await page.evaluate(() => window.dualbody.player.seek(1800));
  const begin = Date.now();
  await drawn(page);
  await page.evaluate(() => window.dualbody.player.seek(3000));
  await drawn(page);
  assert.ok(Date.now() - begin < 2000, `${Date.now() - begin} ms`);
  assert.equal(await page.evaluate(() => Math.round(window.dualbody.player.end)), 3600);
});

test("a browser without WebGL says so and shows the plots", async () => {
  const context = await browser.newContext();
  const page = await context.newPage();
  await page.addInitScript(() => { HTMLCanvasElement.prototype.getContext = ((get) => function (kind, ...rest) { return kind === "webgl2" ? null : get.call(this, kind, ...rest); })(HTMLCanvasElement.prototype.getContext); });
  await page.goto(`file://${process.cwd()}/${CARTPOLE}`);
  await drawn(page);
  assert.match(await page.textContent("#failure"), /WebGL 2 is not available/);
  await page.click("#play");
  await page.waitForTimeout(300);
  assert.ok((await page.evaluate(() => window.dualbody.player.time)) > 0);
  await context.close();
});

for (const size of ["desktop", "phone"])
  for (const scheme of ["light", "dark"])
    for (const [name, file] of [["cartpole", CARTPOLE], ["humanoid", ROBOT], ["hostile", HOSTILE]])
      on(file, { size, scheme }, `text of ${name} is readable: ${size}, ${scheme}`, async (page) => {
        await page.evaluate(() => document.querySelectorAll("details").forEach((part) => { part.open = true; }));
        await drawn(page);
        await screenshot(page, `${name}-${size}-${scheme}`, { fullPage: true });
        const texts = await contrasts(page);
        assert.ok(texts.length > 10);
        for (const { text, contrast, pixels } of texts) {
          assert.ok(contrast >= 4.5, `"${text}" has the contrast ${contrast.toFixed(2)}`);
          assert.ok(pixels >= 12.5, `"${text}" has ${pixels} pixels`);
        }
        assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), "nothing sticks out");
        const small = await page.evaluate(() => [...document.querySelectorAll("#tools button, #play, #theme")].filter((b) => b.checkVisibility() && b.getBoundingClientRect().width < 40).length);
        assert.equal(small, 0, "buttons are as large as a finger");
      });
