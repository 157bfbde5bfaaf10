// Where one looks from: a point, a distance, and two angles in degrees. Mouse, touch and keys move it.

const FIELD_OF_VIEW = (40 * Math.PI) / 180;

class Camera {
  constructor(canvas, changed) {
    Object.assign(this, { canvas, changed, lookAt: [0, 0, 0], distance: 3, azimuth: 30, elevation: 18, pointers: new Map() });
    canvas.addEventListener("pointerdown", (event) => this.down(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    for (const type of ["pointerup", "pointercancel"])
      canvas.addEventListener(type, (event) => this.pointers.delete(event.pointerId));
    canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  /** Puts a box into the picture, as large as it gets: every corner is within the four planes of the view. */
  fit({ low, high }) {
    const center = scaled(add(low, high), 0.5), [x, y, z] = this.axes();
    const t = Math.tan(FIELD_OF_VIEW / 2) * 0.88;
    let distance = 1e-3;
    for (let corner = 0; corner < 8; corner++) {
      const from = subtract([0, 1, 2].map((axis) => ((corner >> axis) & 1 ? high : low)[axis]), center);
      const needed = Math.max(Math.abs(dot(from, x)) / (t * this.aspect()), Math.abs(dot(from, y)) / t);
      distance = Math.max(distance, needed + dot(from, z));
    }
    this.set({ lookAt: center, distance });
  }

  set(values) {
    Object.assign(this, values);
    this.elevation = Math.max(-89, Math.min(89, this.elevation));
    this.azimuth = ((((this.azimuth + 180) % 360) + 360) % 360) - 180;
    this.distance = Math.max(1e-3, Math.min(1e5, this.distance));
    this.changed();
  }

  aspect() {
    return this.canvas.clientWidth / Math.max(this.canvas.clientHeight, 1);
  }

  /** From the point that is looked at to the camera. */
  direction() {
    const [a, e] = [this.azimuth, this.elevation].map((angle) => (angle * Math.PI) / 180);
    return [Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e)];
  }

  /** Right, up and towards the viewer. */
  axes() {
    const z = this.direction(), x = unit(cross([0, 0, 1], z));
    return [x, cross(z, x), z];
  }

  view() {
    const eye = add(this.lookAt, scaled(this.direction(), this.distance));
    const near = this.distance * 0.02, far = this.distance * 60;
    const projection = perspective(FIELD_OF_VIEW, this.aspect(), near, far);
    return { eye, matrix: multiply(projection, looking(eye, this.lookAt, [0, 0, 1])) };
  }

  orbit(dx, dy) {
    this.set({ azimuth: this.azimuth - 0.4 * dx, elevation: this.elevation + 0.4 * dy });
  }

  /** Moves what is looked at along with the pointer, by pixels. */
  pan(dx, dy) {
    const [x, y] = this.axes();
    const pixel = (2 * this.distance * Math.tan(FIELD_OF_VIEW / 2)) / Math.max(this.canvas.clientHeight, 1);
    this.set({ lookAt: add(this.lookAt, add(scaled(x, -dx * pixel), scaled(y, dy * pixel))) });
  }

  zoom(factor) {
    this.set({ distance: this.distance * factor });
  }

  down(event) {
    this.canvas.focus({ preventScroll: true });
    this.canvas.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, [event.clientX, event.clientY]);
  }

  /** One finger or the left button turns; two fingers, or another button, or shift, shift; two fingers zoom as well. */
  move(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const now = [event.clientX, event.clientY], [dx, dy] = [now[0] - before[0], now[1] - before[1]];
    this.pointers.set(event.pointerId, now);
    if (this.pointers.size === 2) {
      const [other] = [...this.pointers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
      const apart = (at) => Math.hypot(at[0] - other[0], at[1] - other[1]);
      this.pan(dx / 2, dy / 2);
      this.zoom(apart(before) / Math.max(apart(now), 1));
    } else if (event.shiftKey || event.buttons & 6) {
      this.pan(dx, dy);
    } else {
      this.orbit(dx, dy);
    }
  }

  wheel(event) {
    event.preventDefault();
    this.zoom(Math.exp(Math.max(-1, Math.min(1, event.deltaY * 0.0015))));
  }
}
