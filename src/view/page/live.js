// A simulation that runs while it is shown: frames from the server, orders to it. Only on pages that a server sends.

/** Where a ray meets a box about the origin, along the ray; null where it does not. */
function meetBox(from, along, half) {
  let near = 0, far = Infinity;
  for (let axis = 0; axis < 3; axis++) {
    const [a, b] = [-half[axis], half[axis]].map((side) => (side - from[axis]) / along[axis]).sort((x, y) => x - y);
    if (Number.isNaN(a) || Number.isNaN(b)) {
      if (Math.abs(from[axis]) > half[axis]) return null;
      continue;
    }
    near = Math.max(near, a);
    far = Math.min(far, b);
  }
  return near <= far ? near : null;
}

/** Half the edges of the box around a shape. */
const halfBox = ({ shape, size: [x, y, z] }) => {
  if (shape === "box") return [x / 2, y / 2, z / 2];
  if (shape === "cylinder") return [x, y, z / 2];
  if (shape === "capsule") return [x, x, x + z / 2];
  return [x, y, z];
};

const turnedBack = ([w, x, y, z]) => [w, -x, -y, -z];
/** A point of the world in a frame. */
const inFrame = (pose, point) => rotate(turnedBack(pose.slice(3)), subtract(point, pose.slice(0, 3)));

class LiveView {
  constructor(scene, camera, canvas, changed) {
    Object.assign(this, { scene, camera, canvas, changed, frame: null, held: null, largest: 0, frames: 0 });
    this.socket = new WebSocket(new URL("socket", location.href.replace(/^http/, "ws")));
    this.socket.addEventListener("message", (event) => this.take(JSON.parse(event.data)));
    this.socket.addEventListener("close", () => { this.status.textContent = "The simulation has ended."; });
    this.makeBar();
    this.makeTargets();
    // Before the camera, which would turn.
    canvas.addEventListener("pointerdown", (event) => this.down(event), { capture: true });
    canvas.addEventListener("pointermove", (event) => this.move(event), { capture: true });
    for (const type of ["pointerup", "pointercancel"]) canvas.addEventListener(type, () => this.up(), { capture: true });
    if (scene) scene.drawMore = (solids) => this.draw(solids);
  }

  order(order) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(order));
  }

  makeBar() {
    const button = (id, label, textContent, act) => {
      const node = element("button", { type: "button", id, title: label, textContent });
      node.addEventListener("click", act);
      return node;
    };
    this.status = element("span", { id: "status" });
    const download = (format) => element("a", { href: `recording.${format}`, download: fileName(format), textContent: format.toUpperCase() });
    byId("time").replaceWith(
      button("step", "One step", "Step", () => this.order({ step: 1 })),
      button("reset", "Back to the start", "Reset", () => { this.largest = 0; this.order("reset"); this.resetTargets(); }),
      this.status, element("span", { id: "save" }, "Save: ", download("html"), " ", download("csv"), " ", download("json")));
    byId("timeline").hidden = false;
    byId("timeline").classList.add("live");
    byId("play").addEventListener("click", () => this.toggle());
    byId("speed").append(...speeds.map((value) => element("option", { value, textContent: `${value}×`, selected: value === 1 })));
    byId("speed").addEventListener("change", () => this.order({ speed: Number(byId("speed").value) }));
  }

  toggle() {
    this.order({ pause: !(this.frame?.paused ?? false) });
  }

  makeTargets() {
    this.targets = data.live.targets.map((target) => {
      const made = makeSlider(target, target.value, (value) => this.order({ target: { input: target.input, value } }));
      return { made, value: target.value };
    });
    if (this.targets.length) byId("panel").prepend(fold("Joints", true, ...this.targets.map(({ made }) => made.node)));
    const help = "Drag a body to pull it; drag the background to rotate the view.";
    byId("panel").prepend(element("p", { className: "help", textContent: help }));
  }

  resetTargets() {
    for (const { made, value } of this.targets) { made.input.value = value; made.show(); }
  }

  take(frame) {
    this.frame = frame;
    this.frames += 1;
    if (this.scene) this.scene.poses = [frame.poses];
    byId("now").textContent = `${frame.time.toFixed(2)} s`;
    byId("play").setAttribute("aria-pressed", String(!frame.paused));
    const slow = !frame.paused && frame.factor < 0.9 * frame.speed;
    this.status.textContent = frame.trouble ?? (slow ? `${frame.factor.toFixed(2)}× real time` : "");
    this.changed();
  }

  /** The ray through a place of the picture. */
  ray(event) {
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    const t = Math.tan(FIELD_OF_VIEW / 2), [x, y, z] = this.camera.axes();
    const right = (2 * (event.clientX - left)) / width - 1, up = 1 - (2 * (event.clientY - top)) / height;
    const along = add(scaled(z, -1), add(scaled(x, right * t * this.camera.aspect()), scaled(y, up * t)));
    return { from: this.camera.view().eye, along };
  }

  /** The nearest body under the pointer, with the place where. */
  pick(event) {
    const { from, along } = this.ray(event);
    let best = null;
    for (const shape of this.scene?.robots[0].shapes ?? []) {
      if (shape.body === null) continue;
      const pose = compose(this.scene.place(0, shape.body), shape.pose);
      const t = meetBox(inFrame(pose, from), rotate(turnedBack(pose.slice(3)), along), halfBox(shape));
      if (t !== null && (!best || t < best.t)) best = { t, body: shape.body };
    }
    return best && { ...best, point: add(from, scaled(along, best.t)) };
  }

  down(event) {
    if (event.button !== 0 || event.shiftKey || !event.isPrimary) return;
    const hit = this.pick(event);
    if (!hit) return;
    event.stopImmediatePropagation();
    this.canvas.setPointerCapture(event.pointerId);
    this.held = { body: hit.body, at: inFrame(this.scene.place(0, hit.body), hit.point), depth: hit.t };
    this.pull(hit.point);
  }

  move(event) {
    if (!this.held) return;
    event.stopImmediatePropagation();
    const { from, along } = this.ray(event);
    this.pull(add(from, scaled(along, this.held.depth)));
  }

  pull(to) {
    const { body, at } = this.held;
    this.order({ drag: { body, at, to } });
  }

  up() {
    if (!this.held) return;
    this.held = null;
    this.order("release");
  }

  /** Forces of contact as arrows, and the spring of the mouse. */
  draw(solids) {
    if (!this.frame) return;
    const { scene } = this, { radius } = scene.bounds;
    if (scene.shows.forces)
      for (const [x, y, z, ...force] of this.frame.contacts) {
        this.largest = Math.max(this.largest, norm(force));
        scene.addArrow(solids, [x, y, z], scaled(force, (0.5 * radius) / this.largest), 0.016 * radius, FORCE);
      }
    if (this.frame.drag) {
      const [x, y, z, ...to] = this.frame.drag;
      scene.addArrow(solids, [x, y, z], subtract(to, [x, y, z]), 0.012 * radius, MARK, true);
    }
  }
}

if (data.live) {
  const live = new LiveView(scene, camera, canvas, touch);
  window.dualbody.live = live;
  Object.assign(KEYS, { " ": () => live.toggle(), ArrowRight: () => live.order({ step: 1 }), Home: () => byId("reset").click() });
}
