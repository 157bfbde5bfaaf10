//! Pairs of convex shapes, and of these with a ring given as a function: distances that are numbers, the same both ways, and normals of length one.

use std::sync::Arc;

use dualbody::autodiff::Dual;
use dualbody::collision::{
    DistanceField, DistanceFunction, Hull, Manifold, Shape, features, nearest_features, witness,
};
use dualbody::spatial::{Quaternion, Transform};
use dualbody::{Cast, Scalar};
use nalgebra::Vector3;

use crate::input::Case;

type Placed = (Shape, Transform<f64>);

/// Length beyond which distances of shapes of about 1 m lose digits; there the check is only that the search ends.
const LARGE: f64 = 1e6;
/// Part of the size by which distances both ways may differ, for sizes and places of any ratio.
const ALIKE: f64 = 1e-6;

/// A torus about z, of a radius and a thickness.
struct Ring(f64, f64);

impl DistanceFunction for Ring {
    fn distance<T: Scalar>(&self, [x, y, z]: [T; 3]) -> T {
        let beyond = (x * x + y * y).sqrt() - self.0;
        (beyond * beyond + z * z).sqrt() - self.1
    }
}

/// Each two shapes that follow each other, a line each: kind, sizes, place, rotation vector.
pub(super) fn check(case: &Case) -> Result<bool, String> {
    let text = case.text();
    let shapes: Vec<Placed> = text.lines().take(12).filter_map(shape_of).collect();
    for pair in shapes.windows(2) {
        check_pair(&pair[0], &pair[1]).map_err(|what| format!("{what}: {pair:?}"))?;
    }
    Ok(shapes.len() > 1)
}

fn shape_of(line: &str) -> Option<Placed> {
    let mut words = line.split_whitespace();
    let kind = words.next()?;
    let numbers: Vec<f64> = words.map_while(|word| word.parse().ok()).collect();
    let rest = &mut numbers.into_iter();
    let vector = |x: [f64; 3]| Vector3::from(x);
    let shape = match kind {
        "sphere" => Shape::Sphere {
            radius: rest.next()?,
        },
        "capsule" => Shape::Capsule {
            radius: rest.next()?,
            half_length: rest.next()?,
        },
        "cylinder" => Shape::Cylinder {
            radius: rest.next()?,
            half_length: rest.next()?,
        },
        "box" => Shape::Box {
            half_extents: three(rest)?,
        },
        "ellipsoid" => Shape::Ellipsoid {
            semi_axes: three(rest)?,
        },
        "triangle" => Shape::Triangle {
            vertices: [
                vector(three(rest)?),
                vector(three(rest)?),
                vector(three(rest)?),
            ],
        },
        "hull" => {
            let corners = (0..6).map(|k| Vector3::ith(k % 3, if k < 3 { 1.0 } else { -0.5 }));
            Shape::Hull {
                hull: Arc::new(Hull::new(corners.collect()).ok()?),
                scale: three(rest)?,
            }
        }
        "field" => ring(rest.next()?, rest.next()?)?,
        _ => Shape::HalfSpace,
    };
    let (at, turn) = (vector(three(rest)?), vector(three(rest)?));
    let turn = if turn.norm() < LARGE {
        turn
    } else {
        Vector3::zeros()
    };
    Some((
        shape,
        Transform::new(Quaternion::exp(&turn).to_matrix(), at),
    ))
}

/// A field's box must be finite and not negative.
fn ring(radius: f64, thickness: f64) -> Option<Shape> {
    let half = radius + thickness;
    let is_allowed = radius >= 0.0 && thickness >= 0.0 && half.is_finite();
    is_allowed.then(|| Shape::Field {
        field: DistanceField::new(Ring(radius, thickness), [half, half, thickness]),
    })
}

fn three(rest: &mut impl Iterator<Item = f64>) -> Option<[f64; 3]> {
    Some([rest.next()?, rest.next()?, rest.next()?])
}

fn check_pair((a, at_a): &Placed, (b, at_b): &Placed) -> Result<(), String> {
    let is_negative = |shape: &Shape| match shape {
        Shape::Sphere { radius } => *radius < 0.0,
        Shape::Capsule {
            radius,
            half_length,
        }
        | Shape::Cylinder {
            radius,
            half_length,
        } => *radius < 0.0 || *half_length < 0.0,
        Shape::Box { half_extents: x } | Shape::Ellipsoid { semi_axes: x } => {
            x.iter().any(|x| *x < 0.0)
        }
        _ => false,
    };
    let mut manifold = Manifold::default();
    features(a, at_a, b, at_b, 0.1, &mut manifold);
    // Sizes below zero are refused where shapes are made: of them only that it ends.
    let size = size_of(a) + size_of(b) + (at_a.translation - at_b.translation).norm();
    if is_negative(a) || is_negative(b) || size.is_nan() || size >= LARGE {
        return Ok(());
    }
    let both = [
        nearest_features(a, at_a, b, at_b).map(|own| witness(&own, a, at_a, b, at_b)),
        nearest_features(b, at_b, a, at_a).map(|own| witness(&own, b, at_b, a, at_a)),
    ];
    let [Some(there), Some(back)] = both else {
        return Ok(());
    };
    let tolerance = ALIKE * size.max(f64::MIN_POSITIVE);
    let is_alike = |x: f64, y: f64| (x - y).abs() <= tolerance;
    if !is_alike(there.distance, back.distance) {
        return Err(format!("{} there, {} back", there.distance, back.distance));
    }
    if (there.normal.norm() - 1.0).abs() > 1e-9 {
        return Err(format!("a normal of length {}", there.normal.norm()));
    }
    for own in manifold.pairs() {
        let lift = |at: &Transform<f64>| {
            let mut at: Transform<Dual<f64, 1>> = at.cast();
            at.translation.x.eps[0] = 1.0;
            at
        };
        let found = witness(own, a, &lift(at_a), b, &at_b.cast());
        if !(found.distance.re.is_finite() && found.distance.eps[0].is_finite()) {
            return Err(format!("a distance {:?} of {own:?}", found.distance));
        }
    }
    Ok(())
}

/// About how large a shape is.
fn size_of(shape: &Shape) -> f64 {
    match shape {
        Shape::Sphere { radius } => *radius,
        Shape::Capsule {
            radius,
            half_length,
        }
        | Shape::Cylinder {
            radius,
            half_length,
        } => radius + half_length,
        Shape::Box { half_extents: x }
        | Shape::Ellipsoid { semi_axes: x }
        | Shape::Hull { scale: x, .. } => x.iter().map(|x| x.abs()).sum(),
        Shape::Triangle { vertices } => vertices.iter().map(|v| v.norm()).sum(),
        Shape::Field { field } => field.half_extents().iter().sum(),
        _ => 0.0,
    }
}
