// Puts everything together.

byId("title").textContent = data.title;
if (data.warnings.length) {
  byId("warnings").hidden = false;
  byId("warnings").firstElementChild.textContent = data.warnings.length === 1 ? "1 warning" : `${data.warnings.length} warnings`;
  byId("warnings").append(element("ul", {}, ...data.warnings.map((textContent) => element("li", { textContent }))));
}

/** Day or night: as the system says, until the button says otherwise. */
const isDark = () => (document.documentElement.dataset.theme ?? (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light")) === "dark";
const SKY = {
  light: { background: [0.955, 0.965, 0.975], ground: [0.905, 0.918, 0.932], lines: [0.66, 0.70, 0.74] },
  dark: { background: [0.085, 0.098, 0.118], ground: [0.125, 0.142, 0.168], lines: [0.30, 0.34, 0.39] },
};

const canvas = byId("view");
let dirty = true, plots = [];
const touch = () => { dirty = true; };
const player = motion && new Player(motion.times, motion.robots, touch);

let renderer = null;
try {
  renderer = new Renderer(canvas);
} catch (error) {
  byId("failure").hidden = false;
  byId("failure").textContent = `This browser cannot draw the robot: ${error.message}. The plots and values below are available.`;
}
const scene = renderer && new Scene(renderer, data.robots, data.fixtures, player);
const camera = new Camera(canvas, touch);
const panel = scene && new Panel(scene, camera, touch);
const wholeRobot = () => scene && camera.fit(scene.bounds.framed);
wholeRobot();
if (data.camera) {
  const { look_at: lookAt, ...rest } = data.camera;
  camera.set({ lookAt, ...rest });
}

document.body.classList.toggle("still", !motion);

// Plots: those of one robot, chosen where there are several, then the series.
function showPlots(robot) {
  plots = [...motion.robots[robot].plots, ...motion.series].map((plot) => new Plot(plot, player));
  byId("plots").replaceChildren(...plots.map((plot) => plot.node));
  touch();
}
if (motion) {
  const shown = player.times.length, span = player.end - player.start;
  byId("about").textContent = `${short(span)} s, ${motion.recorded} states` + (shown < motion.recorded ? `, ${shown} shown` : "");
  if (data.robots.length > 1) {
    const choice = byId("robot");
    choice.append(...data.robots.map(({ name }, value) => element("option", { value, textContent: name })));
    choice.addEventListener("change", () => showPlots(Number(choice.value)));
    byId("choice").hidden = false;
  }
  showPlots(0);
}

// The timeline.
const slider = byId("time"), speeds = [0.1, 0.25, 0.5, 1, 2, 4, 10];
if (player) {
  byId("timeline").hidden = false;
  Object.assign(slider, { min: player.start, max: player.end, step: "any" });
  slider.addEventListener("input", () => player.seek(Number(slider.value)));
  byId("play").addEventListener("click", () => player.play(!player.playing));
  byId("speed").append(...speeds.map((value) => element("option", { value, textContent: `${value}×`, selected: value === 1 })));
  byId("speed").addEventListener("change", () => { player.speed = Number(byId("speed").value); });
}
function changeSpeed(direction) {
  const k = speeds.indexOf(player.speed) + direction;
  if (k < 0 || k >= speeds.length) return;
  player.speed = speeds[k];
  byId("speed").value = String(speeds[k]);
}

function picture() {
  // In the same task as the drawing, before the browser clears it.
  drawScene();
  canvas.toBlob((blob) => blob && save(blob, fileName("png")), "image/png");
}
const video = new Video(canvas, byId("video"));
byId("fit").addEventListener("click", wholeRobot);
byId("picture").addEventListener("click", picture);
byId("video").addEventListener("click", () => video.toggle());
byId("theme").addEventListener("click", () => {
  document.documentElement.dataset.theme = isDark() ? "light" : "dark";
  touch();
});

const KEYS = {
  " ": () => player?.play(!player.playing), ArrowLeft: () => player?.step(-1), ArrowRight: () => player?.step(1),
  Home: () => player?.seek(player.start), End: () => player?.seek(player.end),
  "-": () => player && changeSpeed(-1), "+": () => player && changeSpeed(1), "=": () => player && changeSpeed(1),
  f: () => panel?.flip("frames"), m: () => panel?.flip("com"), i: () => panel?.flip("inertia"),
  r: wholeRobot, p: picture, v: () => video.toggle(),
};
document.addEventListener("keydown", (event) => {
  // Where something is typed or chosen, keys belong to it; a focused button keeps its space.
  const { tagName } = event.target, own = event.target === slider;
  if (event.ctrlKey || event.metaKey || event.altKey || (!own && ["INPUT", "SELECT"].includes(tagName))) return;
  if (event.key === " " && ["BUTTON", "SUMMARY"].includes(tagName)) return;
  const action = KEYS[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  if (!action) return;
  event.preventDefault();
  action();
});

function drawScene() {
  if (!scene) return;
  renderer.resize();
  scene.update();
  scene.draw(camera.view(), SKY[isDark() ? "dark" : "light"]);
}

function show() {
  drawScene();
  panel?.showCamera();
  plots.forEach((plot) => plot.draw());
  if (!player) return;
  slider.value = String(player.time);
  byId("now").textContent = `${player.time.toFixed(2)} s`;
  byId("play").setAttribute("aria-pressed", String(player.playing));
  byId("play").title = player.playing ? "Pause (space)" : "Play (space)";
}

let last = performance.now();
function frame(now) {
  player?.advance(Math.min((now - last) / 1000, 0.25));
  last = now;
  // While a video is recorded every picture is drawn, so that time passes in it.
  if (dirty || video.recorder) {
    dirty = false;
    show();
  }
  requestAnimationFrame(frame);
}
new ResizeObserver(touch).observe(document.body);
new ResizeObserver(touch).observe(canvas);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", touch);
requestAnimationFrame(frame);

// For scripts and for the console of the browser.
window.dualbody = { data, motion, player, scene, camera, panel, video };
