// Collisions on pages with sliders, against closed forms: no browser is needed.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

const script = ["math", "collide"].map((name) => readFileSync(`src/view/page/${name}.js`, "utf8")).join("\n");
const { overlap, rotate, subtract, dot, cross, norm, unit } =
  new Function("data", "decode", `${script}; return { overlap, rotate, subtract, dot, cross, norm, unit };`)({}, (x) => x);

// A small generator, so that every run is the same.
let seed = 1;
const random = () => {
  seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
  return seed / 2 ** 31 - 1;
};
const somewhere = () => {
  const q = [random(), random(), random(), random()], n = Math.hypot(...q);
  return [random(), random(), random(), ...q.map((x) => x / n)];
};
const size = () => 0.3 + 0.2 * random();
const shape = (points, disc, radius, reach) => ({ points, disc, radius, middle: [0, 0, 0], reach: reach + radius });
const ball = (r) => shape([0, 0, 0], 0, r, 0);
const cylinder = (r, half) => shape([0, 0, -half, 0, 0, half], r, 0, Math.hypot(r, half));
const box = (half) =>
  shape([0, 1, 2, 3, 4, 5, 6, 7].flatMap((k) => [0, 1, 2].map((axis) => ((k >> axis) & 1 ? 1 : -1) * half[axis])), 0, 0, norm(half));

/** A point in the axes of a pose. */
const within = (pose, point) => {
  const [w, x, y, z] = pose.slice(3);
  return rotate([w, -x, -y, -z], subtract(point, pose.slice(0, 3)));
};

/** Compares on many places; `gap` gives the distance, or less than zero. */
function compare(make, gap) {
  let touching = 0;
  for (let k = 0; k < 5000; k++) {
    const [a, b] = make(), [at, other] = [somewhere(), somewhere()], distance = gap(a, at, b, other);
    if (Math.abs(distance) < 1e-6) continue;
    touching += distance < 0;
    assert.equal(overlap(a.shape, at, b.shape, other), distance < 0, `${distance}`);
    assert.equal(overlap(b.shape, other, a.shape, at), distance < 0, `turned ${distance}`);
  }
  assert.ok(touching > 200, `${touching}`);
}

test("a ball and a box overlap where the ball is nearer than its radius", () => {
  const make = () => {
    const half = [size(), size(), size()], r = size();
    return [{ shape: box(half), half }, { shape: ball(r), r }];
  };
  compare(make, (a, at, b, other) => {
    const p = within(at, other.slice(0, 3));
    return Math.hypot(...p.map((x, axis) => Math.max(0, Math.abs(x) - a.half[axis]))) - b.r;
  });
});

test("a ball and a cylinder overlap where the ball is nearer than its radius", () => {
  const make = () => {
    const [radius, half, r] = [size(), size(), size()];
    return [{ shape: cylinder(radius, half), radius, half }, { shape: ball(r), r }];
  };
  compare(make, (a, at, b, other) => {
    const p = within(at, other.slice(0, 3));
    return Math.hypot(Math.max(0, Math.hypot(p[0], p[1]) - a.radius), Math.max(0, Math.abs(p[2]) - a.half)) - b.r;
  });
});

test("two boxes overlap where no axis separates them", () => {
  const make = () => [0, 1].map(() => {
    const half = [size(), size(), size()];
    return { shape: box(half), half };
  });
  compare(make, (a, at, b, other) => {
    const axes = (pose) => [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((axis) => rotate(pose.slice(3), axis));
    const [A, B] = [axes(at), axes(other)], apart = subtract(other.slice(0, 3), at.slice(0, 3));
    const along = (own, half, axis) => own.reduce((sum, edge, k) => sum + half[k] * Math.abs(dot(edge, axis)), 0);
    const all = [...A, ...B, ...A.flatMap((x) => B.map((y) => cross(x, y))).filter((x) => norm(x) > 1e-6).map(unit)];
    return Math.max(...all.map((axis) => Math.abs(dot(apart, axis)) - along(A, a.half, axis) - along(B, b.half, axis)));
  });
});
