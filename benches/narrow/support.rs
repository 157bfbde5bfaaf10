//! Support functions of shapes, written apart from those of the library.

use dualbody::collision::Shape;

use super::pairs::{Pair, Pose, V};

/// Difference of heights of vertices on one face, m: more only takes longer.
const LEVEL: f64 = 1e-6;
/// Length that is rounding, m.
const ROUNDING: f64 = 1e-14;

/// The point of a shape that lies farthest along a direction, without the radius around a ball or a capsule, in the world.
pub(crate) fn farthest(shape: &Shape, at: &Pose, n: &V) -> V {
    let m = at.rotation.transpose() * n;
    let sign = |x: f64| 1_f64.copysign(x);
    let own = match shape {
        Shape::Capsule { half_length, .. } => V::z() * (half_length * sign(m.z)),
        Shape::Box { half_extents: h } => V::from_fn(|k, _| h[k] * sign(m[k])),
        Shape::Cylinder {
            radius,
            half_length,
        } => {
            let across = V::new(m.x, m.y, 0.0);
            let rim = across.try_normalize(0.0).unwrap_or_else(V::zeros);
            rim * *radius + V::z() * (half_length * sign(m.z))
        }
        Shape::Ellipsoid { semi_axes } if ball(semi_axes).is_none() => {
            let s = V::from(*semi_axes);
            let unit = s.component_mul(&m).try_normalize(0.0);
            s.component_mul(&unit.unwrap_or_else(V::zeros))
        }
        Shape::Hull { hull, scale } => {
            let s = V::from(*scale);
            best(hull.vertices().iter().map(|v| v.component_mul(&s)), &m)
        }
        Shape::Triangle { vertices } => best(vertices.iter().copied(), &m),
        _ => V::zeros(),
    };
    at.rotation * own + at.translation
}

fn best(points: impl Iterator<Item = V>, m: &V) -> V {
    let farther = |a: V, b: V| if b.dot(m) > a.dot(m) { b } else { a };
    points.reduce(farther).expect("a point")
}

/// Radius around what [`farthest`] reaches.
pub(crate) fn radius(shape: &Shape) -> f64 {
    match shape {
        Shape::Sphere { radius } | Shape::Capsule { radius, .. } => *radius,
        Shape::Ellipsoid { semi_axes } => ball(semi_axes).unwrap_or(0.0),
        _ => 0.0,
    }
}

/// The radius of an ellipsoid that is a ball.
fn ball([a, b, c]: &[f64; 3]) -> Option<f64> {
    (a == b && b == c).then_some(*a)
}

/// Gap between planes across a unit direction with the shapes on either side, m. That of a half-space is finite along its normal only.
pub(crate) fn gap(pair: &Pair, n: &V) -> f64 {
    let normal = |k: usize| pair.at[k].rotation.column(2).into_owned();
    for (k, sign) in [(0, 1.0), (1, -1.0)] {
        let is_endless = matches!(pair.shapes[k], Shape::HalfSpace);
        if is_endless && (normal(k) * sign - n).norm() > 1e-12 {
            return f64::NEG_INFINITY;
        }
    }
    difference(pair, n).dot(n) - radii(pair)
}

/// The least difference q − p along a direction, of the second shape's points those of the first, without radii.
pub(crate) fn difference(pair: &Pair, n: &V) -> V {
    let [a, b] = &pair.shapes;
    farthest(b, &pair.at[1], &-n) - farthest(a, &pair.at[0], n)
}

pub(crate) fn radii(pair: &Pair) -> f64 {
    radius(&pair.shapes[0]) + radius(&pair.shapes[1])
}

/// How far a point on the surface of a shape is outside of it, m.
///
/// * `n` – normal out of the shape there: a hull is searched at the vertices that lie farthest along it
pub(crate) fn outside(shape: &Shape, at: &Pose, p: &V, n: &V) -> f64 {
    let x = at.rotation.transpose() * (p - at.translation);
    match shape {
        Shape::Sphere { radius } => x.norm() - radius,
        Shape::Capsule {
            radius,
            half_length,
        } => (x - V::z() * x.z.clamp(-half_length, *half_length)).norm() - radius,
        Shape::Box { half_extents: h } => {
            (0..3).fold(f64::NEG_INFINITY, |most, k| most.max(x[k].abs() - h[k]))
        }
        Shape::Cylinder {
            radius,
            half_length,
        } => (x.z.abs() - half_length).max(x.x.hypot(x.y) - radius),
        Shape::Ellipsoid { semi_axes: s } => outside_ellipsoid(&x, s),
        Shape::Triangle { vertices } => outside_triangle(&x, vertices),
        Shape::HalfSpace => x.z,
        Shape::Hull { hull, scale } => {
            let s = V::from(*scale);
            let vertices = hull.vertices().iter().map(|v| v.component_mul(&s));
            outside_hull(&x, vertices.collect(), &(at.rotation.transpose() * n))
        }
        _ => f64::NEG_INFINITY,
    }
}

/// A bound of the distance from an ellipsoid: that from the point drawn to its surface towards the centre, with flat axes first made flat.
fn outside_ellipsoid(x: &V, s: &[f64; 3]) -> f64 {
    let flat = |k: usize| s[k] < 1e-8;
    let inside = V::from_fn(|k, _| {
        if flat(k) {
            x[k].clamp(-s[k], s[k])
        } else {
            x[k]
        }
    });
    let beyond = (0..3).filter(|&k| !flat(k)).map(|k| (x[k] / s[k]).powi(2));
    let factor = beyond.sum::<f64>().sqrt().max(1.0);
    (inside / factor - x).norm()
}

/// Distance from the triangles between the vertices that lie farthest along a direction: a bound of that from the hull.
fn outside_hull(x: &V, mut vertices: Vec<V>, n: &V) -> f64 {
    let farthest = vertices.iter().map(|v| v.dot(n)).fold(f64::MIN, f64::max);
    vertices.retain(|v| v.dot(n) >= farthest - LEVEL);
    let mut least = f64::INFINITY;
    for (k, c) in vertices.iter().enumerate() {
        for (j, b) in vertices[..=k].iter().enumerate() {
            for a in &vertices[..=j] {
                if least > ROUNDING {
                    least = least.min(outside_triangle(x, &[*a, *b, *c]));
                }
            }
        }
    }
    least
}

/// Distance from a triangle, by its plane and its sides.
fn outside_triangle(x: &V, v: &[V; 3]) -> f64 {
    let on = |a: &V, b: &V| {
        let u = b - a;
        let t = u.dot(&(x - a)) / u.norm_squared().max(f64::MIN_POSITIVE);
        (a + u * t.clamp(0.0, 1.0) - x).norm()
    };
    let sides = on(&v[0], &v[1]).min(on(&v[1], &v[2])).min(on(&v[2], &v[0]));
    let normal = (v[1] - v[0]).cross(&(v[2] - v[0]));
    let beside = |a: &V, b: &V| (b - a).cross(&(x - a)).dot(&normal) >= 0.0;
    let is_above = beside(&v[0], &v[1]) && beside(&v[1], &v[2]) && beside(&v[2], &v[0]);
    match normal.try_normalize(0.0) {
        Some(n) if is_above => sides.min(n.dot(&(x - v[0])).abs()),
        _ => sides,
    }
}
