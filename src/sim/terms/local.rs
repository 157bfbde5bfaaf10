//! Numbers with derivatives in the local inputs of a term: one width for a coordinate, one for a body.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{Matrix3, Vector3};

use crate::constraint::CarrierMotion;
use crate::scalar::{Dual, MapEach, Scalar, from_each};
use crate::spatial::linear::{cross, rotate};
use crate::spatial::{Force, Motion, SPATIAL, Transform};

/// A value that depends on one coordinate and its input only.
pub(crate) type OfCoordinate<T = f64> = Dual<T, COORDINATE_DIRECTIONS>;

pub(super) const COORDINATE_DIRECTIONS: usize = TIME_STEP + 1;

/// Directions of a coordinate, and that of the time step, where it has one.
pub(super) const POSITION: usize = 0;
pub(super) const RATE: usize = 1;
pub(super) const INPUT: usize = 2;
pub(super) const TIME_STEP: usize = 3;

/// A value that depends on one body only. The first directions are those of its pose (a motion of the body, in the body) and of its velocity (in the
/// body); the term defines the others.
pub(crate) type OfBody<T = f64> = Dual<T, BODY_DIRECTIONS>;

pub(super) const BODY_DIRECTIONS: usize = FURTHER + 4;

/// The first direction of the velocity, and the first that is a term's own.
const VELOCITY: usize = SPATIAL;
pub(super) const FURTHER: usize = 2 * SPATIAL;

/// Derivatives of one quantity of a body.
pub(super) trait BodyDerivatives<T> {
    /// In the pose: a force on the body, in the body.
    fn in_pose(&self) -> Force<T>;

    /// In the velocity.
    fn in_velocity(&self) -> Force<T>;

    /// Along a motion of the body.
    fn by_pose(&self, V: &Motion<T>) -> T;

    /// Along a change of its velocity.
    fn by_velocity(&self, V: &Motion<T>) -> T;
}

impl<T: Scalar> BodyDerivatives<T> for OfBody<T> {
    fn in_pose(&self) -> Force<T> {
        slopes_from(self, 0)
    }

    fn in_velocity(&self) -> Force<T> {
        slopes_from(self, VELOCITY)
    }

    #[inline(always)]
    fn by_pose(&self, V: &Motion<T>) -> T {
        along(&self.eps[..VELOCITY], V)
    }

    #[inline(always)]
    fn by_velocity(&self, V: &Motion<T>) -> T {
        along(&self.eps[VELOCITY..FURTHER], V)
    }
}

fn slopes_from<T: Scalar>(x: &OfBody<T>, first: usize) -> Force<T> {
    Force::from_array(from_each(|k| x.eps[first + k]))
}

#[inline(always)]
fn along<T: Scalar>(slopes: &[T], V: &Motion<T>) -> T {
    let (mut sum, V) = (T::zero(), V.to_array());
    for k in 0..SPATIAL {
        sum += slopes[k] * V[k];
    }
    sum
}

/// One derivative of each coordinate of a force, or its values.
pub(super) fn part<T: Scalar>(F: &Force<OfBody<T>>, of: impl Fn(&OfBody<T>) -> T) -> Force<T> {
    Force::from_array(F.to_array().map_each(|x| of(&x)))
}

/// X exp(ξ) to first order in ξ, a motion of B in B, along the first six directions: δp = R ξᵥ, δR = R `[ξ_ω]×`.
pub(super) fn seeded_pose<T: Scalar>(X: &Transform<T>) -> Transform<OfBody<T>> {
    let mut out = constant_pose(X);
    for k in 0..3 {
        let e = unit(k);
        let shift = rotate(&X.rotation, &e);
        for row in 0..3 {
            out.translation[row].eps[k] = shift[row];
        }
        let turn: Matrix3<T> = Matrix3::from_columns(&std::array::from_fn::<_, 3, _>(|column| {
            rotate(&X.rotation, &cross(&e, &unit(column)))
        }));
        let entries = out.rotation.iter_mut().zip(turn.iter());
        entries.for_each(|(x, &dx)| x.eps[3 + k] = dx);
    }
    out
}

/// V with a derivative of one in each of its coordinates.
pub(super) fn seeded_velocity<T: Scalar>(V: &Motion<T>) -> Motion<OfBody<T>> {
    let mut out = constant_motion(V);
    for k in 0..SPATIAL {
        out.coordinate_mut(k).eps[VELOCITY + k] = T::one();
    }
    out
}

/// A pose without derivatives.
#[inline(always)]
pub(super) fn constant_pose<T: Scalar>(X: &Transform<T>) -> Transform<OfBody<T>> {
    let rotation = X.rotation.map(Dual::constant_of);
    Transform::new(rotation, X.translation.map(Dual::constant_of))
}

/// A motion without derivatives.
#[inline(always)]
pub(super) fn constant_motion<T: Scalar>(V: &Motion<T>) -> Motion<OfBody<T>> {
    let angular = V.angular.map(Dual::constant_of);
    Motion::new(V.linear.map(Dual::constant_of), angular)
}

/// Motions of both bodies with derivatives in pose and velocity of one.
pub(super) fn in_directions_of<T: Scalar>(
    side: usize,
    motions: &[CarrierMotion<T>; 2],
) -> [CarrierMotion<OfBody<T>>; 2] {
    from_each(|i| {
        let at = &motions[i];
        let (X_WB, V) = match i == side {
            true => (seeded_pose(&at.X_WB), seeded_velocity(&at.V)),
            false => (constant_pose(&at.X_WB), constant_motion(&at.V)),
        };
        CarrierMotion {
            X_WB,
            V,
            bias: constant_motion(&at.bias),
            U: constant_motion(&at.U),
        }
    })
}

fn unit<T: Scalar>(k: usize) -> Vector3<T> {
    Vector3::from_fn(|i, _| if i == k { T::one() } else { T::zero() })
}
