// Vectors [x, y, z]; quaternions [w, x, y, z]; poses [x, y, z, w, i, j, k]; matrices of 16, column by column, as WebGL has them.

const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const subtract = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const scaled = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const norm = (a) => Math.hypot(a[0], a[1], a[2]);
const unit = (a) => { const n = norm(a); return n > 0 ? scaled(a, 1 / n) : [0, 0, 1]; };

/** Product of rotations. */
function turn(a, b) {
  return [
    a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
    a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
    a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
    a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
  ];
}

/** p + 2 w (u × p) + 2 u × (u × p) with the quaternion (w, u). */
function rotate(q, p) {
  const u = [q[1], q[2], q[3]], t = scaled(cross(u, p), 2);
  return add(add(p, scaled(t, q[0])), cross(u, t));
}

const IDENTITY = [0, 0, 0, 1, 0, 0, 0];

/** The pose of C in A from those of B in A and of C in B. */
function compose(ab, bc) {
  const q = ab.slice(3), p = rotate(q, bc.slice(0, 3));
  return [...add(ab.slice(0, 3), p), ...turn(q, bc.slice(3))];
}

/** A point of frame B in A. */
const transformPoint = (ab, p) => add(ab.slice(0, 3), rotate(ab.slice(3), p));

/** Between two poses: positions along a line, rotations by the shorter way. */
function interpolate(a, b, s) {
  const sign = a[3] * b[3] + a[4] * b[4] + a[5] * b[5] + a[6] * b[6] < 0 ? -1 : 1;
  const out = a.map((x, i) => x * (1 - s) + (i < 3 ? b[i] : sign * b[i]) * s);
  const length = Math.hypot(out[3], out[4], out[5], out[6]) || 1;
  for (let i = 3; i < 7; i++) out[i] /= length;
  return out;
}

/** The rotation that turns z to a direction. */
function turnedTo(direction) {
  const d = unit(direction);
  if (d[2] < -0.999999) return [0, 1, 0, 0];
  const q = [1 + d[2], -d[1], d[0], 0], length = Math.hypot(...q);
  return q.map((x) => x / length);
}

/** The matrix of a pose. */
function matrix(pose) {
  const q = pose.slice(3);
  const [x, y, z] = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((axis) => rotate(q, axis));
  return [...x, 0, ...y, 0, ...z, 0, pose[0], pose[1], pose[2], 1];
}

function multiply(a, b) {
  const out = new Array(16).fill(0);
  for (let column = 0; column < 4; column++)
    for (let row = 0; row < 4; row++)
      for (let k = 0; k < 4; k++) out[4 * column + row] += a[4 * k + row] * b[4 * column + k];
  return out;
}

/** World to a camera that looks along −z. */
function looking(eye, at, up) {
  const z = unit(subtract(eye, at)), x = unit(cross(up, z)), y = cross(z, x);
  return [x[0], y[0], z[0], 0, x[1], y[1], z[1], 0, x[2], y[2], z[2], 0, -dot(x, eye), -dot(y, eye), -dot(z, eye), 1];
}

function perspective(height, aspect, near, far) {
  const f = 1 / Math.tan(height / 2), d = 1 / (near - far);
  return [f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (near + far) * d, -1, 0, 0, 2 * near * far * d, 0];
}

function orthographic(radius, near, far) {
  const d = 1 / (near - far);
  return [1 / radius, 0, 0, 0, 0, 1 / radius, 0, 0, 0, 0, 2 * d, 0, 0, 0, (near + far) * d, 1];
}
