//! Random pairs of shapes of every two kinds: near, deep, far, aligned, and with sizes of slivers or of zero.

use std::sync::Arc;

use dualbody::collision::{Hull, Shape};
use dualbody::spatial::{Quaternion, Transform};
use nalgebra::{Matrix3, Vector3};
use rand::RngExt;
use rand::rngs::Xoshiro256PlusPlus;

use super::support::gap;

pub(crate) type V = Vector3<f64>;
pub(crate) type Pose = Transform<f64>;
pub(crate) type Random = Xoshiro256PlusPlus;

/// Kinds of shapes; the last can only be one of a pair.
pub(crate) const KINDS: [&str; 8] = [
    "sphere",
    "capsule",
    "box",
    "cylinder",
    "ellipsoid",
    "hull",
    "triangle",
    "half-space",
];

/// Where shapes are, and how they are shaped.
pub(crate) const REGIMES: [&str; 5] = ["near", "deep", "far", "aligned", "sliver"];

/// Thickness of a sliver, m.
const SLIVER: f64 = 1e-9;
/// Pitch of the grid on which aligned shapes are centred, m.
const PITCH: f64 = 0.25;

/// Two shapes at their poses.
#[derive(Clone, Debug)]
pub(crate) struct Pair {
    pub(crate) shapes: [Shape; 2],
    pub(crate) at: [Pose; 2],
}

impl Pair {
    /// A pair of two kinds in a regime, by their indices.
    pub(crate) fn random(rng: &mut Random, kinds: [usize; 2], regime: usize) -> Self {
        let shapes = kinds.map(|kind| shape(kind, regime, rng));
        let distance = [1.5, 0.3, 3.0, 0.0, 1.0][regime];
        let at = match regime {
            3 => [(); 2].map(|()| aligned_pose(rng)),
            _ => [(); 2].map(|()| pose(rng, distance)),
        };
        let mut own = Self { shapes, at };
        if regime == 0 {
            own.bring_near(rng);
        }
        own
    }

    /// Moves the second shape along a random direction until planes across it are up to 0.05 m apart.
    fn bring_near(&mut self, rng: &mut Random) {
        let n = vector(rng, 1.0).normalize();
        let wanted = rng.random_range(-0.05..0.05);
        let now = gap(self, &n);
        if now.is_finite() {
            self.at[1].translation += n * (wanted - now);
        }
    }
}

/// Each two kinds, the second not before the first; two half-spaces have no distance.
pub(crate) fn kinds() -> impl Iterator<Item = [usize; 2]> {
    let last = KINDS.len() - 1;
    let pairs = (0..=last).flat_map(move |a| (a..=last).map(move |b| [a, b]));
    pairs.filter(move |&[a, _]| a < last)
}

pub(crate) fn vector(rng: &mut Random, size: f64) -> V {
    V::from_fn(|_, _| rng.random_range(-size..size))
}

fn pose(rng: &mut Random, size: f64) -> Pose {
    let rotation = Quaternion::exp(&vector(rng, 2.0)).to_matrix();
    Transform::new(rotation, vector(rng, size))
}

/// A pose whose axes are those of the world in some order, exactly or up to a small angle, at a place of a grid.
fn aligned_pose(rng: &mut Random) -> Pose {
    let mut turn = Matrix3::identity();
    for axis in 0..3 {
        let angle = std::f64::consts::FRAC_PI_2 * f64::from(rng.random_range(0..4));
        turn = Quaternion::exp(&V::ith(axis, angle)).to_matrix() * turn;
    }
    if rng.random_range(0..2) == 0 {
        turn = turn.map(f64::round);
    }
    if rng.random_range(0..3) == 0 {
        let by = 10_f64.powf(rng.random_range(-12.0..-2.0));
        turn = Quaternion::exp(&vector(rng, by)).to_matrix() * turn;
    }
    let place = V::from_fn(|_, _| PITCH * f64::from(rng.random_range(-4..5)));
    Transform::new(turn, place)
}

/// A size of a shape of a regime, m.
fn size(regime: usize, rng: &mut Random) -> f64 {
    match (regime, rng.random_range(0..6)) {
        (3, 0) => 0.0,
        (3, _) => 0.5,
        (4, 0..3) => SLIVER,
        (4, 3) => 0.0,
        _ => rng.random_range(0.1..1.0),
    }
}

fn shape(kind: usize, regime: usize, rng: &mut Random) -> Shape {
    let [a, b, c] = [(); 3].map(|()| size(regime, rng));
    match kind {
        0 => Shape::Sphere { radius: a },
        1 => Shape::Capsule {
            radius: a,
            half_length: b,
        },
        2 => Shape::Box {
            half_extents: [a, b, c],
        },
        3 => Shape::Cylinder {
            radius: a,
            half_length: b,
        },
        4 => Shape::Ellipsoid {
            semi_axes: [a, b, c],
        },
        5 => Shape::Hull {
            hull: Arc::new(hull(regime, rng)),
            scale: [a, b, -c],
        },
        6 => triangle(c, rng),
        _ => Shape::HalfSpace,
    }
}

/// Twelve random points; of an aligned pair the corners of a prism.
fn hull(regime: usize, rng: &mut Random) -> Hull {
    let corner = |k: u32| V::from_fn(|axis, _| f64::from(k >> axis & 1) - 0.5);
    let points = match regime {
        3 => (0..6).map(corner).collect(),
        _ => (0..12).map(|_| vector(rng, 1.0)).collect(),
    };
    Hull::new(points).expect("finite points")
}

/// A triangle about the origin, of a width.
fn triangle(width: f64, rng: &mut Random) -> Shape {
    let a = vector(rng, 1.0);
    let b = a * -0.5 + vector(rng, 1.0) * width;
    Shape::Triangle {
        vertices: [a, b, -(a + b)],
    }
}
