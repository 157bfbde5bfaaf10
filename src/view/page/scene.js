// The robots, and what stands beside them, as things to draw.

const PLAIN = [[0.55, 0.62, 0.72], [0.80, 0.62, 0.45], [0.52, 0.70, 0.58], [0.70, 0.58, 0.74]];
const AXES = [[0.90, 0.25, 0.22, 1], [0.25, 0.70, 0.28, 1], [0.25, 0.45, 0.95, 1]];
const MARK = [0.98, 0.80, 0.18, 1];
const ELLIPSOID = [0.35, 0.65, 0.95, 0.45];
const FORCE = [0.90, 0.22, 0.36, 1];
const CONTACT = [0.98, 0.62, 0.10, 1];
const COLLIDING = [0.90, 0.16, 0.16];
const BONDS = { rod: [0.62, 0.64, 0.68, 1], ball: [0.85, 0.62, 0.20, 1], weld: [0.85, 0.62, 0.20, 1], coupler: [0.55, 0.35, 0.75, 1] };
const TRACES = [[0.91, 0.30, 0.24, 1], [0.16, 0.55, 0.85, 1], [0.20, 0.65, 0.40, 1], [0.62, 0.36, 0.78, 1]];

/** Half the diagonal of a piece: everything of it is within. */
const reach = ({ shape, size }) => {
  if (shape === "box") return norm(size) / 2;
  if (shape === "sphere") return Math.max(...size);
  if (shape === "cylinder") return Math.hypot(size[0], size[2] / 2);
  if (shape === "capsule") return size[0] + size[2] / 2;
  return norm(size);
};

/** The box that the camera shows at first: moving bodies over their whole motion, objects beside them, and the fixed parts around these. */
function framed(moving, whole) {
  if (!(moving.low[0] < moving.high[0])) return whole;
  const margin = 0.2 * norm(subtract(moving.high, moving.low));
  return {
    low: moving.low.map((x, axis) => Math.max(x - margin, Math.min(x, whole.low[axis]))),
    high: moving.high.map((x, axis) => Math.min(x + margin, Math.max(x, whole.high[axis]))),
  };
}

class Scene {
  constructor(renderer, robots, fixtures, player) {
    Object.assign(this, { renderer, robots, fixtures, player, highlighted: null, colliding: new Set() });
    this.shows = { frames: false, com: false, inertia: false, traces: true, forces: true, contacts: true, constraints: true };
    this.framesShown = robots.map((robot) => new Set(robot.shown));
    this.fixturesShown = fixtures.map(() => true);
    this.poses = robots.map((robot) => this.still(robot, {}));
    this.bounds = this.findBounds();
    this.traces = this.findTraces();
    this.forceScale = this.findForceScale();
    this.contactScale = this.findContactScale();
  }

  /**
   * The poses of the bodies of a robot with its sliders at values by coordinate. This turns or shifts each body about its own z
   * axis and carries along what hangs on it; all other poses were computed by the library.
   */
  still(robot, values) {
    const poses = [];
    for (const { parent, placement, motion, pitch, slider } of robot.bodies) {
      const x = slider ? (values[slider.coordinate] ?? 0) * slider.ratio + slider.offset : 0;
      const angle = motion === "slide" ? 0 : x, advance = motion === "slide" ? x : x * (pitch ?? 0);
      const moved = [0, 0, advance, Math.cos(angle / 2), 0, 0, Math.sin(angle / 2)];
      const own = motion === "still" ? placement : compose(placement, moved);
      poses.push(parent === null ? own : compose(poses[parent], own));
    }
    return poses;
  }

  /** Takes the poses at the time that is shown. */
  update() {
    if (this.player) this.poses = this.robots.map((_, i) => this.player.poses(i));
  }

  /** Marks the bodies whose links collide in the poses of now; the names of the links, pair by pair. */
  markCollisions() {
    const found = collisions ? findCollisions(collisions, (body) => (body === null ? IDENTITY : this.poses[0][body])) : [];
    this.colliding = new Set(found.flat().map((k) => collisions.shapes[k].body));
    return [...new Set(found.map((pair) => pair.map((k) => collisions.shapes[k].link).join(" – ")))];
  }

  /** The pose of a body (null: the world) of a robot in the picture. */
  place(robot, body, poses = this.poses[robot]) {
    const { placement } = this.robots[robot];
    return body === null ? placement : compose(placement, poses[body]);
  }

  /** A box and a ball around everything at any time, the ground below it, and the spacing of its grid. */
  findBounds() {
    const empty = () => ({ low: [Infinity, Infinity, Infinity], high: [-Infinity, -Infinity, -Infinity] });
    const whole = empty(), moving = empty(), { low, high } = whole;
    const takeIn = (box, point, radius) => {
      for (let axis = 0; axis < 3; axis++) {
        box.low[axis] = Math.min(box.low[axis], point[axis] - radius);
        box.high[axis] = Math.max(box.high[axis], point[axis] + radius);
      }
    };
    let lowest = Infinity;
    const takeShape = (pose, shape, moves) => {
      const centre = pose.slice(0, 3);
      // Long things count with their ends, so that the ball is not much larger than they are.
      const long = shape.size[2] * (shape.shape === "mesh" ? 1 : 0.5), thick = shape.shape === "sphere" || shape.shape === "mesh";
      const half = thick ? [0, 0, 0] : rotate(pose.slice(3), [0, 0, long]);
      const radius = thick ? reach(shape) : Math.hypot(shape.size[0], shape.size[1]) / (shape.shape === "box" ? 2 : 1);
      for (const sign of [-1, 1])
        for (const box of moves ? [whole, moving] : [whole]) takeIn(box, add(centre, scaled(half, sign)), radius);
      lowest = Math.min(lowest, centre[2] - Math.max(Math.abs(half[2]), thick ? radius : 0));
    };
    for (const poses of this.samples())
      this.robots.forEach((robot, i) => {
        for (const shape of robot.shapes) takeShape(compose(this.place(i, shape.body, poses[i]), shape.pose), shape, shape.body !== null);
      });
    const grounds = this.fixtures.filter(({ is_ground: isGround }) => isGround);
    for (const { axes, shapes, is_ground: isGround } of this.fixtures) {
      if (isGround) continue;
      if (axes) for (const box of [whole, moving]) takeIn(box, axes, 0);
      for (const shape of shapes) takeShape(shape.pose, shape, true);
    }
    if (!(low[0] < high[0])) takeIn(whole, [0, 0, 0.5], 0.5);
    const center = scaled(add(low, high), 0.5), radius = Math.max(norm(subtract(high, low)) / 2, 1e-3);
    const spacing = 10 ** Math.round(Math.log10(radius / 2));
    // Feet sink in a little; what hangs far below the origin has its ground there.
    const found = lowest < -0.05 * radius ? lowest : Math.min(0, center[2]);
    const ground = grounds.find(({ level }) => level !== null)?.level ?? found;
    // A ground that is not level is a surface of its own.
    const hasFloor = grounds.every(({ level }) => level !== null);
    return { low, high, center, radius, ground, hasFloor, spacing, framed: framed(moving, whole) };
  }

  /** Poses of all robots at some moments. */
  *samples() {
    if (!this.player) return yield this.poses;
    const { times } = this.player, step = Math.max(1, Math.floor(times.length / 60));
    for (let k = 0; k < times.length; k += step)
      yield this.robots.map((robot, i) => robot.bodies.map((_, body) => this.player.poseAt(i, body, k)));
  }

  findTraces() {
    if (!this.player) return [];
    const { times } = this.player;
    return this.robots.flatMap((robot, i) => robot.traces.map((f) => {
      const { body, pose } = robot.frames[f], points = new Float32Array(3 * times.length);
      for (let k = 0; k < times.length; k++) {
        const at = body === null ? IDENTITY : this.player.poseAt(i, body, k);
        points.set(transformPoint(compose(robot.placement, at), pose.slice(0, 3)), 3 * k);
      }
      return this.renderer.line(points);
    }));
  }

  /** Metres a newton: the largest force of all times is as long as half the robot. */
  findForceScale() {
    let largest = 0;
    for (const { forces } of this.player?.robots ?? [])
      for (const { values } of forces)
        for (let k = 0; k < values.length; k += 3) {
          const size = Math.hypot(values[k], values[k + 1], values[k + 2]);
          if (size > largest) largest = size;
        }
    return largest > 0 ? (0.5 * this.bounds.radius) / largest : 0;
  }

  /** Metres a newton at points of contact: impacts are far larger than what follows, so that nine in ten are shorter than a fifth of the robot. */
  findContactScale() {
    const sizes = [];
    for (const { contacts } of this.player?.robots ?? [])
      for (let k = 0; k < (contacts?.values.length ?? 0); k += 6) sizes.push(norm(contacts.values.subarray(k + 3, k + 6)));
    const typical = sizes.sort((a, b) => a - b)[Math.floor(0.9 * sizes.length)] ?? 0;
    return typical > 0 ? (0.2 * this.bounds.radius) / typical : 0;
  }

  draw(view, colors) {
    const solids = [], bounds = this.bounds;
    this.robots.forEach((robot, i) => {
      for (const shape of robot.shapes) this.addShape(solids, i, shape);
      this.addFrames(solids, i);
      robot.bodies.forEach((body, b) => this.addInertia(solids, i, body, b));
      if (this.shows.constraints) for (const bond of robot.bonds) this.addBond(solids, i, bond);
    });
    this.fixtures.forEach((fixture, k) => this.fixturesShown[k] && this.addFixture(solids, fixture));
    if (this.shows.contacts) this.player?.robots.forEach((_, i) => this.addContacts(solids, i));
    if (this.shows.forces) this.player?.robots.forEach((robot, i) => this.addForces(solids, i, robot));
    this.drawMore?.(solids);
    const now = this.player ? this.player.place(this.player.time).index : 0;
    const ribbons = this.shows.traces ? this.traces.map((line, k) => ({ line, now, color: TRACES[k % TRACES.length] })) : [];
    this.renderer.draw(solids, ribbons, view, bounds, colors);
  }

  addShape(solids, i, shape) {
    const { body, color } = shape;
    let paint = color ?? [...PLAIN[i % PLAIN.length], 1];
    if (this.colliding.has(body) && i === 0) paint = [...COLLIDING, paint[3]];
    if (this.highlighted && this.highlighted.robot === i && this.highlighted.body === body) paint = [...MARK.slice(0, 3), paint[3]];
    this.addPiece(solids, compose(this.place(i, body), shape.pose), paint, shape);
  }

  /** Size of a cylinder as it is drawn: a long rod is not thinner than a few pixels of the first view. */
  visible([radius, , length]) {
    const { low, high } = this.bounds.framed, least = Math.min(0.004 * norm(subtract(high, low)), 0.02 * length);
    return [Math.max(radius, least), Math.max(radius, least), length];
  }

  addFixture(solids, { axes, shapes }) {
    for (const shape of shapes) this.addPiece(solids, shape.pose, shape.color, shape);
    if (axes) this.addAxes(solids, axes);
  }

  /** A shape at a pose in the world. */
  addPiece(solids, world, paint, { shape, size, mesh }, above = false) {
    const put = (name, make, at, scale) =>
      solids.push({ shape: this.renderer.shape(name, make), pose: matrix(at), scale, color: paint, shadow: paint[3] > 0.5, above });
    if (shape === "box") put("box", boxShape, world, size);
    else if (shape === "mesh") put(`mesh ${mesh}`, () => meshShape(data.meshes[mesh]), world, size);
    else if (shape === "sphere") put("sphere", sphereShape, world, size);
    else put("cylinder", cylinderShape, world, shape === "cylinder" ? this.visible(size) : size);
    if (shape === "capsule")
      for (const side of [-1, 1])
        put("sphere", sphereShape, compose(world, [0, 0, (side * size[2]) / 2, 1, 0, 0, 0]), [size[0], size[0], size[0]]);
  }

  addArrow(solids, from, along, thick, color, above = false) {
    const length = norm(along);
    if (!(length > 0)) return;
    const q = turnedTo(along), tip = Math.min(4 * thick, 0.5 * length), stem = length - tip;
    const put = (name, make, offset, scale) =>
      solids.push({ shape: this.renderer.shape(name, make), pose: matrix(compose([...from, ...q], [0, 0, offset, 1, 0, 0, 0])), scale, color, above });
    put("cylinder", cylinderShape, stem / 2, [thick / 2, thick / 2, stem]);
    put("tip", tipShape, stem, [1.4 * thick, 1.4 * thick, tip]);
  }

  addFrames(solids, i) {
    this.robots[i].frames.forEach(({ body, pose }, f) => {
      if (this.shows.frames || this.framesShown[i].has(f)) this.addAxes(solids, compose(this.place(i, body), pose));
    });
  }

  addAxes(solids, at) {
    const length = 0.09 * this.bounds.radius;
    [[1, 0, 0], [0, 1, 0], [0, 0, 1]].forEach((axis, k) =>
      this.addArrow(solids, at.slice(0, 3), scaled(rotate(at.slice(3), axis), length), 0.09 * length, AXES[k], true));
  }

  addInertia(solids, i, { com, ellipsoid, mass }, b) {
    if (this.shows.com && mass > 0) {
      const pose = matrix([...transformPoint(this.place(i, b), com), 1, 0, 0, 0]), r = 0.018 * this.bounds.radius;
      solids.push({ shape: this.renderer.shape("sphere", sphereShape), pose, scale: [r, r, r], color: MARK, above: true });
    }
    if (this.shows.inertia && ellipsoid) {
      const [pose, radii] = ellipsoid, least = 0.004 * this.bounds.radius;
      solids.push({
        shape: this.renderer.shape("sphere", sphereShape), pose: matrix(compose(this.place(i, b), pose)),
        scale: radii.map((r) => Math.max(r, least)), color: ELLIPSOID,
      });
    }
  }

  /**
   * What holds two places together: a rod, or a mark at both where they should be one, with a line where they are not. Marks stand inside of
   * bodies, and shine through.
   */
  addBond(solids, i, { kind, ends }) {
    const [from, to] = ends.map(({ body, at }) => transformPoint(this.place(i, body), at));
    const along = subtract(to, from), length = norm(along), thick = 0.012 * this.bounds.radius, color = BONDS[kind];
    const above = kind !== "rod";
    if (length > 0.1 * thick) {
      const radius = kind === "rod" ? thick : 0.3 * thick, middle = add(from, scaled(along, 0.5));
      const piece = { shape: "cylinder", size: [radius, radius, length] };
      this.addPiece(solids, [...middle, ...turnedTo(along)], color, piece, above);
    }
    const mark = kind === "weld" ? { shape: "box", size: [3 * thick, 3 * thick, 3 * thick] } : { shape: "sphere", size: [2.2 * thick, 2.2 * thick, 2.2 * thick] };
    if (kind !== "coupler") ends.forEach(({ body }, k) => {
      const turn = this.place(i, body).slice(3);
      this.addPiece(solids, [...(k ? to : from), ...turn], color, mark, above);
    });
  }

  /** A ball at each point of contact, and the force there, not longer than half the robot. */
  addContacts(solids, i) {
    const { placement } = this.robots[i], { radius } = this.bounds, ball = 0.012 * radius;
    for (const [at, force] of this.player.contacts(i)) {
      const from = transformPoint(placement, at), size = norm(force) * this.contactScale;
      if (!Number.isFinite(size)) continue;
      this.addPiece(solids, [...from, 1, 0, 0, 0], CONTACT, { shape: "sphere", size: [ball, ball, ball] }, true);
      const along = rotate(placement.slice(3), scaled(force, this.contactScale * Math.min(1, (0.5 * radius) / size)));
      this.addArrow(solids, from, along, 0.008 * radius, CONTACT, true);
    }
  }

  addForces(solids, i, robot) {
    robot.forces.forEach(({ frame }, k) => {
      const { body, pose } = this.robots[i].frames[frame], force = this.player.force(i, k);
      if (!force.every(Number.isFinite)) return;
      const along = rotate(this.robots[i].placement.slice(3), scaled(force, this.forceScale));
      this.addArrow(solids, transformPoint(this.place(i, body), pose.slice(0, 3)), along, 0.016 * this.bounds.radius, FORCE);
    });
  }
}
