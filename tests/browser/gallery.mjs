// Makes the pictures of the README: one of each example's page, at a moment at which there is something to see.
//
// Run every example first: they write the pages.

import { mkdirSync, statSync } from "node:fs";
import { drawn, open, start } from "./browser.mjs";

const FOLDER = "assets/gallery", MOST_BYTES = 60_000;
const WIDTH = 480, HEIGHT = 300;

/** Example, moment in s, and where to look from if not as the page does. */
const PICTURES = [
  ["pendulum", 0.45, { azimuth: 55, elevation: 12 }],
  ["inverse_dynamics", 0.2, { azimuth: 40, elevation: 16 }],
  ["derivatives", 8.37, { azimuth: 20, elevation: 8 }],
  ["batch", 0.25, { azimuth: 38, elevation: 20, distance: 6, lookAt: [2.2, 0, 1.5] }],
  ["computed_torque", 0.3, { azimuth: 20, elevation: 12, distance: 3.2, lookAt: [0, 0, 1.2] }],
  ["cartpole", 0.25, null],
  ["pages", 1.05, { azimuth: 25, elevation: 14, distance: 3.6, lookAt: [0, 0.4, 1.2] }],
];

mkdirSync(FOLDER, { recursive: true });
const browser = await start();
for (const [name, time, camera] of PICTURES) {
  const { page, close } = await open(browser, `out/${name}/index.html`, { viewport: { width: 1000, height: 900 } });
  // Only the canvas, in the size of the picture.
  await page.addStyleTag({ content: `#view { position: fixed; inset: 0; width: ${WIDTH}px; height: ${HEIGHT}px; z-index: 1; } #tools { display: none !important; }` });
  await drawn(page);
  await page.evaluate(([time, camera]) => {
    const { player, scene, camera: own, data } = window.dualbody;
    if (camera) own.set(camera);
    if (!data.camera && !camera?.distance) own.fit(scene.bounds);
    player.seek(time);
  }, [time, camera]);
  await drawn(page);
  const path = `${FOLDER}/${name}.png`;
  await page.screenshot({ path, clip: { x: 0, y: 0, width: WIDTH, height: HEIGHT } });
  const { size } = statSync(path);
  console.log(`${path}: ${size} bytes`);
  if (size > MOST_BYTES) throw new Error(`${path} is larger than ${MOST_BYTES} bytes`);
  await close();
}
await browser.close();
