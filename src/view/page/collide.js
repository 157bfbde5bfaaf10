// Which shapes overlap: the method of Gilbert, Johnson and Keerthi, for pages with sliders. Distances and forces are computed by the library only.

/** Collision shapes of a page with sliders, with the middle of each and how far it reaches from there. */
const collisions = data.collisions && {
  ...data.collisions,
  shapes: data.collisions.shapes.map((shape) => {
    const points = decode(shape.points), middle = [0, 1, 2].map((axis) => {
      let [low, high] = [Infinity, -Infinity];
      for (let k = axis; k < points.length; k += 3) [low, high] = [Math.min(low, points[k]), Math.max(high, points[k])];
      return (low + high) / 2;
    });
    let reach = 0;
    for (let k = 0; k < points.length; k += 3) reach = Math.max(reach, norm(subtract([points[k], points[k + 1], points[k + 2]], middle)));
    return { ...shape, points, middle, reach: reach + shape.disc + shape.radius };
  }),
};

/** The farthest point of a shape at a pose along a direction, of its hull without the radius around it. */
function supportOf({ points, disc }, pose, direction) {
  const q = pose.slice(3), local = rotate([q[0], -q[1], -q[2], -q[3]], direction);
  let best = 0, most = -Infinity;
  for (let k = 0; k < points.length; k += 3) {
    const along = points[k] * local[0] + points[k + 1] * local[1] + points[k + 2] * local[2];
    if (along > most) [most, best] = [along, k];
  }
  const point = [points[best], points[best + 1], points[best + 2]], across = Math.hypot(local[0], local[1]);
  if (disc > 0 && across > 0) {
    point[0] += (disc * local[0]) / across;
    point[1] += (disc * local[1]) / across;
  }
  return transformPoint(pose, point);
}

/** The simplex, newest corner first, without the corners that the origin is not near, and the direction to the origin; null: it is inside. */
function nearer(simplex) {
  const [a, b, c, d] = simplex, out = scaled(a, -1);
  if (simplex.length === 1) return { simplex, direction: out };
  const ab = subtract(b, a);
  if (simplex.length === 2)
    return dot(ab, out) > 0 ? { simplex, direction: cross(cross(ab, out), ab) } : { simplex: [a], direction: out };
  const ac = subtract(c, a), abc = cross(ab, ac);
  if (simplex.length === 3) {
    if (dot(cross(abc, ac), out) > 0)
      return dot(ac, out) > 0 ? { simplex: [a, c], direction: cross(cross(ac, out), ac) } : nearer([a, b]);
    if (dot(cross(ab, abc), out) > 0) return nearer([a, b]);
    return dot(abc, out) > 0 ? { simplex, direction: abc } : { simplex: [a, c, b], direction: scaled(abc, -1) };
  }
  const ad = subtract(d, a);
  if (dot(abc, out) > 0) return nearer([a, b, c]);
  if (dot(cross(ac, ad), out) > 0) return nearer([a, c, d]);
  if (dot(cross(ad, ab), out) > 0) return nearer([a, d, b]);
  return null;
}

/** Whether two shapes at their poses overlap. */
function overlap(a, poseA, b, poseB) {
  const round = a.radius + b.radius, centre = subtract(transformPoint(poseB, b.middle), transformPoint(poseA, a.middle));
  if (norm(centre) > a.reach + b.reach) return false;
  // The difference of the shapes, with all roundness added to the second one.
  const support = (direction) => {
    const point = subtract(supportOf(a, poseA, direction), supportOf(b, poseB, scaled(direction, -1)));
    return add(point, scaled(unit(direction), round));
  };
  let simplex = [support([0, 0, 1])], direction = scaled(simplex[0], -1);
  for (let k = 0; k < 64; k++) {
    if (norm(direction) < 1e-12) return true;
    const point = support(direction);
    if (dot(point, direction) < 0) return false;
    const next = nearer([point, ...simplex]);
    if (!next) return true;
    ({ simplex, direction } = next);
  }
  return true;
}

/** The shapes that collide at poses of the bodies: indices of pairs. */
function findCollisions({ shapes, pairs }, place) {
  const poses = shapes.map(({ body, pose }) => compose(place(body), pose));
  return pairs.filter(([i, j]) => overlap(shapes[i], poses[i], shapes[j], poses[j]));
}
