// Makes the pictures of examples/README.md: one of each example's page, at a moment at which there is something to see; of those that are named, or of all.

import { mkdirSync, statSync, writeFileSync } from "node:fs";
import { drawn, open, start } from "./browser.mjs";
import { picture } from "./png.mjs";

const FOLDER = "assets/gallery", MOST_BYTES = 60_000;
const WIDTH = 480, HEIGHT = 300;

/** Example, moment in s, where to look from if not as the page does, and another page than its first. */
const PICTURES = [
  ["pendulum", 0.52, { azimuth: 25, elevation: 10, distance: 2.1, lookAt: [0, 0, -0.3] }],
  ["inverse_dynamics", 0.2, { azimuth: -40, elevation: 14, distance: 1.9, lookAt: [0.2, 0.2, 0.45] }],
  ["derivatives", 8.37, { azimuth: 15, elevation: 8, distance: 3.4, lookAt: [0, 0, -0.6] }],
  ["batch", 0.25, { azimuth: 42, elevation: 14, distance: 4.6, lookAt: [2.6, 0, 1.5] }],
  ["computed_torque", 0.3, { azimuth: 20, elevation: 12, distance: 2.2, lookAt: [0, 0.2, 1.1] }],
  ["cartpole", 0.1, null],
  ["pages", 0, { azimuth: 35, elevation: 12 }, "humanoid.html"],
  ["cartpole_swing_up", 1, { azimuth: 25, elevation: 12, distance: 2.9, lookAt: [0, -0.2, 1.15] }],
  ["acrobot_swing_up", 2.9, { azimuth: 65, elevation: 6, distance: 9.3, lookAt: [0, 0, 3.2] }],
  ["arm_reach", 0.75, { azimuth: 20, elevation: 16, distance: 1.9, lookAt: [0.2, 0.25, 0.45] }],
  ["quadruped_jump_in_flight", 0.42, { azimuth: 55, elevation: 10, distance: 1.5 }],
  ["obstacle_course", 1, null],
  ["hopper", 0.6, { azimuth: -75, elevation: 8, distance: 1.5, lookAt: [0.2, 0, 0.35] }],
  ["hopper_codesign", 0.3, { azimuth: -75, elevation: 8, distance: 1.4, lookAt: [0.08, 0, 0.36] }],
  ["payload", 0.5, { azimuth: 30, elevation: 14, distance: 2.0, lookAt: [0.2, 0.25, 0.0] }],
  ["falling_spheres", 0.35, { azimuth: 30, elevation: 14, distance: 2.6, lookAt: [0.4, 0.4, 0.4] }],
  ["bouncing_ball", 2.3, { azimuth: -75, elevation: 8, distance: 2.2, lookAt: [0.5, 0, 0.5] }],
  ["box_on_incline", 0.45, { azimuth: 60, elevation: 16, distance: 2.4, lookAt: [-0.4, 0, -0.1] }],
  ["quadruped_stand", 0.12, { azimuth: 40, elevation: 12, distance: 1.4 }],
  ["quadruped_walk", 2.05, { azimuth: -60, elevation: 10, distance: 1.5, lookAt: [1.5, 0, 0.2] }],
  ["four_bar", 0.6, { azimuth: -75, elevation: 8, distance: 1.1, lookAt: [0.2, 0, 0.7] }],
  ["quadrotor", 5.2, { azimuth: -75, elevation: 10, distance: 3.7, lookAt: [0, 0, 0.95] }],
  ["two_arms", 0.3, { azimuth: -60, elevation: 14, distance: 3.2, lookAt: [0, 0, 1.1] }],
  ["newtons_cradle", 0.0, { azimuth: -75, elevation: 8, distance: 1.6, lookAt: [0.1, 0, 0.75] }],
  ["stack", 0.9, { azimuth: -65, elevation: 12, distance: 2.2, lookAt: [0.3, 0, 0.2] }],
  ["gripper", 0.9, { azimuth: -70, elevation: 12, distance: 0.8, lookAt: [0, 0, 0.25] }],
  ["push_box", 0.9, { azimuth: -60, elevation: 32, distance: 0.7, lookAt: [0.08, 0, 0.03] }],
  ["reach_around", 0.9, { azimuth: -60, elevation: 10, distance: 2.2, lookAt: [0.35, 0, 0.4] }],
  ["dominoes", 0.5, { azimuth: -60, elevation: 16, distance: 0.9, lookAt: [0.24, 0, 0.05] }],
  ["pour", 0.35, { azimuth: 35, elevation: 25, distance: 1.3, lookAt: [0, 0, 0.15] }],
  ["mpc_cartpole", 1, { azimuth: 25, elevation: 12, distance: 2.9, lookAt: [0, 0.1, 1.4] }],
];

mkdirSync(FOLDER, { recursive: true });
const browser = await start();
const named = process.argv.slice(2);
for (const [name, time, camera, file = "index.html"] of PICTURES.filter(([name]) => !named.length || named.includes(name))) {
  const { page, close } = await open(browser, `out/${name}/${file}`, { viewport: { width: 1000, height: 900 } });
  // Only the canvas, in the size of the picture.
  await page.addStyleTag({ content: `#view { position: fixed; inset: 0; width: ${WIDTH}px; height: ${HEIGHT}px; z-index: 1; } #tools { display: none !important; }` });
  await drawn(page);
  await page.evaluate(([time, camera]) => {
    const { player, scene, camera: own, data } = window.dualbody;
    if (camera) own.set(camera);
    if (!data.camera && !camera?.distance) own.fit(scene.bounds.framed);
    player?.seek(time);
  }, [time, camera]);
  await drawn(page);
  const path = `${FOLDER}/${name}.png`;
  writeFileSync(path, await picture(page, { x: 0, y: 0, width: WIDTH, height: HEIGHT }));
  const { size } = statSync(path);
  console.log(`${path}: ${size} bytes`);
  if (size > MOST_BYTES) throw new Error(`${path} is larger than ${MOST_BYTES} bytes`);
  await close();
}
await browser.close();
