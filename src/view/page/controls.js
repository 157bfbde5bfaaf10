// What a person touches beside the picture: buttons, switches, sliders, the tree, keys.

/** A labelled switch. */
function makeSwitch(label, checked, changed) {
  const box = element("input", { type: "checkbox", checked });
  box.addEventListener("change", () => changed(box.checked));
  return { box, node: element("label", { className: "switch" }, box, element("span", { textContent: label })) };
}

/** A slider with its name and value. */
function makeSlider({ name, lower, upper, unit: dimension }, value, changed) {
  const input = element("input", { type: "range", min: lower, max: upper, step: "any", value });
  const shown = element("output");
  const show = () => { shown.textContent = `${(Math.round(1000 * input.value) / 1000 || 0).toFixed(3)} ${dimension}`; };
  input.setAttribute("aria-label", name);
  input.addEventListener("input", () => { show(); changed(Number(input.value)); });
  show();
  const node = element("label", { className: "slider" }, element("span", { className: "name", textContent: name, title: name }), shown, input);
  return { input, show, node };
}

/** A part of the panel that can be folded. */
const fold = (title, open, ...children) =>
  element("details", { open }, element("summary", { textContent: title }), ...children);

class Panel {
  constructor(scene, camera, changed) {
    Object.assign(this, { scene, camera, changed, switches: {}, joints: [] });
    const parts = [this.makeSwitches()];
    if (scene.fixtures.length) parts.push(this.makeFixtures());
    if (!scene.player && !data.live) parts.push(this.makeJoints());
    parts.push(this.makeCamera(), ...this.makeTrees(), this.makeKeys());
    byId("panel").append(...parts);
  }

  makeSwitches() {
    const { shows, traces, player, robots } = this.scene, forces = data.live || player?.robots.some((robot) => robot.forces.length);
    const constraints = robots.some((robot) => robot.bonds.length);
    const all = [["frames", "Frames", true], ["com", "Centres of mass", true], ["inertia", "Inertia ellipsoids", true],
      ["traces", "Traces", traces.length > 0], ["forces", "Forces", forces], ["contacts", "Contacts", player?.robots.some((robot) => robot.contacts?.values.length)], ["constraints", "Constraints", constraints]];
    const nodes = all.filter(([, , useful]) => useful).map(([key, label]) => {
      this.switches[key] = makeSwitch(label, shows[key], (on) => { shows[key] = on; this.changed(); });
      return this.switches[key].node;
    });
    return fold("Show", true, ...nodes);
  }

  /** A switch for each thing that stands beside the robots. */
  makeFixtures() {
    const { fixtures, fixturesShown } = this.scene;
    const nodes = fixtures.map(({ name }, k) => makeSwitch(name, true, (on) => { fixturesShown[k] = on; this.changed(); }).node);
    return fold("Scenery", true, ...nodes);
  }

  flip(key) {
    this.switches[key]?.box.click();
  }

  /** A slider for each joint that has a coordinate of its own; the zero of a joint may be outside its limits. */
  makeJoints() {
    const [robot] = this.scene.robots, values = {};
    const nodes = [];
    for (const { slider } of robot.bodies) {
      if (!slider?.own) continue;
      const zero = Math.max(slider.own.lower, Math.min(slider.own.upper, 0));
      values[slider.coordinate] = zero;
      const made = makeSlider(slider.own, zero, (value) => { values[slider.coordinate] = value; move(); });
      this.joints.push({ made, zero, slider });
      nodes.push(made.node);
    }
    const message = element("p", { className: "collisions", ariaLive: "polite" });
    const move = () => {
      this.scene.poses[0] = this.scene.still(robot, values);
      const found = this.scene.markCollisions();
      message.textContent = found.length ? `Collides: ${found.join(", ")}` : "";
      message.hidden = !found.length;
      this.changed();
    };
    const reset = element("button", { type: "button", textContent: "All to zero" });
    reset.addEventListener("click", () => {
      for (const { made, zero, slider } of this.joints) { made.input.value = zero; made.show(); values[slider.coordinate] = zero; }
      move();
    });
    move();
    if (!nodes.length) return fold("Joints", true, element("p", { textContent: "No joint of one degree of freedom." }));
    const parts = [...nodes, reset, message];
    if (collisions?.touching.length) {
      const names = collisions.touching.map((pair) => pair.join(" – ")).join(", ");
      parts.push(element("p", { textContent: `Not checked, because they collide with all joints at zero: ${names}.` }));
    }
    return fold("Joints", true, ...parts);
  }

  makeCamera() {
    const fields = [["Look at x", "m", 0], ["Look at y", "m", 1], ["Look at z", "m", 2], ["Distance", "m", "distance"],
      ["Azimuth", "°", "azimuth"], ["Elevation", "°", "elevation"]];
    this.cameraInputs = fields.map(([label, dimension, key]) => {
      const input = element("input", { type: "number", step: "any" });
      input.addEventListener("change", () => {
        const value = Number(input.value);
        if (!Number.isFinite(value)) return;
        if (typeof key === "string") this.camera.set({ [key]: value });
        else this.camera.set({ lookAt: this.camera.lookAt.map((x, axis) => (axis === key ? value : x)) });
      });
      const node = element("label", { className: "field" }, element("span", { textContent: label }), input, element("span", { textContent: dimension }));
      return { input, key, node };
    });
    return fold("Camera", false, ...this.cameraInputs.map(({ node }) => node));
  }

  showCamera() {
    for (const { input, key } of this.cameraInputs) {
      const value = typeof key === "string" ? this.camera[key] : this.camera.lookAt[key];
      if (document.activeElement !== input) input.value = String(Number(value.toPrecision(5)));
    }
  }

  /** The links as a tree; pointing at one marks what moves with it, a click shows its frame. */
  makeTrees() {
    const many = this.scene.robots.length > 1;
    return this.scene.robots.slice(0, 4).map((robot, i) => {
      const lines = robot.links.map((link) => {
        const { body } = robot.frames[link.frame], shown = this.scene.framesShown[i];
        const button = element("button", { type: "button" }, element("span", { className: "link", textContent: link.name }));
        if (link.joint) button.append(element("span", { className: "joint", textContent: link.joint }));
        button.style.paddingInlineStart = `${0.4 + 0.7 * Math.min(link.depth, 12)}rem`;
        button.setAttribute("aria-pressed", String(shown.has(link.frame)));
        const mark = (on) => { this.scene.highlighted = on ? { robot: i, body } : null; this.changed(); };
        button.addEventListener("pointerenter", () => mark(true));
        button.addEventListener("pointerleave", () => mark(false));
        button.addEventListener("click", () => {
          if (!shown.delete(link.frame)) shown.add(link.frame);
          button.setAttribute("aria-pressed", String(shown.has(link.frame)));
          this.changed();
        });
        return button;
      });
      return fold(many ? `Links of ${robot.name}` : "Links", !this.scene.player, element("div", { className: "tree" }, ...lines));
    });
  }

  makeKeys() {
    const keys = [["Space", "play, pause"], ["← →", "one moment back, on"], ["Home End", "to the start, the end"], ["− +", "slower, faster"],
      ["F", "frames"], ["M", "centres of mass"], ["I", "ellipsoids of inertia"], ["R", "whole robot into view"], ["P", "save a picture"], ["V", "record a video"]];
    const moving = ["Space", "← →", "Home End", "− +"];
    const rows = keys.filter(([key]) => this.scene.player || !moving.includes(key));
    const list = element("dl", {}, ...rows.flatMap(([key, text]) => [element("dt", { textContent: key }), element("dd", { textContent: text })]));
    const help = "Drag to rotate. Drag with two fingers, Shift or the right button to move. Pinch or scroll to zoom.";
    return fold("Keys and mouse", false, list, element("p", { textContent: help }));
  }
}

/** Hands a file to the person. */
function save(blob, name) {
  const url = URL.createObjectURL(blob);
  element("a", { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 10000);
}

/** A file name out of the title. */
const fileName = (ending) => `${data.title.replace(/[^\p{L}\p{N}._-]+/gu, "_").slice(0, 60) || "robot"}.${ending}`;

/** Records what the canvas shows as WebM, from one press of the button to the next. */
class Video {
  constructor(canvas, button) {
    Object.assign(this, { canvas, button, recorder: null });
  }

  toggle() {
    if (this.recorder) return this.recorder.stop();
    const types = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm"];
    const mimeType = window.MediaRecorder && types.find((type) => MediaRecorder.isTypeSupported(type));
    if (!mimeType) return say("This browser cannot record WebM.");
    const parts = [];
    this.recorder = new MediaRecorder(this.canvas.captureStream(60), { mimeType, videoBitsPerSecond: 8e6 });
    this.recorder.addEventListener("dataavailable", (event) => parts.push(event.data));
    this.recorder.addEventListener("stop", () => {
      save(new Blob(parts, { type: "video/webm" }), fileName("webm"));
      this.recorder = null;
      this.button.setAttribute("aria-pressed", "false");
    });
    this.recorder.start();
    this.button.setAttribute("aria-pressed", "true");
  }
}

/** A short message over the picture. */
function say(text) {
  const node = byId("message");
  node.textContent = text;
  node.hidden = false;
  clearTimeout(say.timer);
  say.timer = setTimeout(() => { node.hidden = true; }, 4000);
}
