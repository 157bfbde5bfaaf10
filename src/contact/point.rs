//! Where a body can touch the ground.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{Matrix3, Vector3};

use crate::model::{BodyId, FrameId};
use crate::scalar::{Over, Scalar};
use crate::spatial::linear::{add_cross, cross, dot, lift_vector, rotate_back, scale};
use crate::spatial::{Force, Motion};

/// The part of a shape that touches.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Feature<P = f64> {
    /// A corner: the centre itself.
    Corner,
    /// The lowest point of a sphere about the centre: it rolls.
    Sphere {
        /// Radius, m.
        radius: P,
    },
    /// A point of a circle about the centre, at an angle from its lowest one.
    Rim {
        /// Normal of the circle, in the body frame, a unit vector.
        axis: Vector3<P>,
        /// Radius, m.
        radius: P,
        /// Angle from the lowest point about the axis, rad.
        angle: f64,
    },
}

/// A point of a body that can touch the ground; where exactly depends on how the body lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPoint<P = f64> {
    /// The link whose shape it belongs to.
    pub link: FrameId,
    /// The body that the link is part of.
    pub body: BodyId,
    /// The centre in the body frame, m.
    pub center: Vector3<P>,
    /// What touches there.
    pub feature: Feature<P>,
}

/// How far the lowest point of a rim must be below its centre, by its radius, to be found by that alone: below it, when the circle
/// lies nearly flat, a direction fixed to the body decides more and more. Smaller follows the true lowest point further, and lets it
/// run faster around a rim that is nearly flat.
const RIM_HOLD: f64 = 1e-2;

impl<P: Scalar> ContactPoint<P> {
    /// The same point over another scalar.
    pub fn cast<Q: Over<P>>(&self) -> ContactPoint<Q> {
        let vector = |x: &Vector3<P>| lift_vector(x);
        ContactPoint {
            link: self.link,
            body: self.body,
            center: vector(&self.center),
            feature: match self.feature {
                Feature::Corner => Feature::Corner,
                Feature::Sphere { radius } => Feature::Sphere {
                    radius: radius.into(),
                },
                Feature::Rim {
                    axis,
                    radius,
                    angle,
                } => Feature::Rim {
                    axis: vector(&axis),
                    radius: radius.into(),
                    angle,
                },
            },
        }
    }

    /// Where the point is in the body frame, for an outward normal of the ground there (both in the body frame).
    #[inline(always)]
    pub(super) fn locate<T: Over<P>>(&self, normal: &Vector3<T>) -> Vector3<T> {
        let center: Vector3<T> = lift_vector(&self.center);
        match self.feature {
            Feature::Corner => center,
            Feature::Sphere { radius } => center - scale(normal, radius.into()),
            Feature::Rim {
                axis,
                radius,
                angle,
            } => {
                let axis: Vector3<T> = lift_vector(&axis);
                center + scale(&rim_direction(&axis, normal, angle), radius.into())
            }
        }
    }
}

/// The unit vector from the centre of a circle to its lowest point, turned about the axis by an angle.
fn rim_direction<T: Scalar>(axis: &Vector3<T>, normal: &Vector3<T>, angle: f64) -> Vector3<T> {
    let along = dot(normal, axis);
    let down = scale(axis, along) - normal;
    let w = down + scale(&perpendicular(axis), T::constant(RIM_HOLD));
    // The two parts never cancel for long: where they do, the second one is kept.
    let square = dot(&w, &w);
    let least = T::constant(RIM_HOLD * RIM_HOLD * RIM_HOLD);
    let d = scale(&w, T::one() / least.select_lt(square, square, least).sqrt());
    let (sin, cos) = angle.sin_cos();
    d * T::constant(cos) + cross(axis, &d) * T::constant(sin)
}

/// A unit vector across another one, without a jump near the axes that shapes have.
fn perpendicular<T: Scalar>(axis: &Vector3<T>) -> Vector3<T> {
    let zero = T::zero();
    let (x, z) = (
        Vector3::new(axis.z, zero, -axis.x),
        Vector3::new(-axis.y, axis.x, zero),
    );
    // Across z or x where that is long enough, else across the other one.
    let half = T::constant(0.5);
    let pick = |a: T, b: T| half.select_lt(dot(&x, &x), a, b);
    let out = Vector3::new(pick(x.x, z.x), pick(x.y, z.y), pick(x.z, z.z));
    scale(&out, T::one() / dot(&out, &out).sqrt())
}

/// Velocity, in the body frame, of the body at a point of it.
#[inline(always)]
pub(super) fn velocity_at<T: Scalar>(V: &Motion<T>, point: &Vector3<T>) -> Vector3<T> {
    add_cross(&V.linear, &V.angular, point)
}

/// What a force (world axes, N) at a point of a body is to the body, in its frame with the rotation `R_WB`.
#[inline(always)]
pub(crate) fn body_force<T: Scalar>(
    R_WB: &Matrix3<T>,
    point: &Vector3<T>,
    force: &Vector3<T>,
) -> Force<T> {
    let f_B = rotate_back(R_WB, force);
    Force::new(f_B, cross(point, &f_B))
}
