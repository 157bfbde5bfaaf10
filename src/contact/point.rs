//! Contact points and round shapes of a body.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{Matrix3, Vector3};

use crate::model::{BodyId, FrameId, Model};
use crate::numbers::{Domain, Numbers, each_lane, numbers};
use crate::scalar::{MapEach, Over, Scalar};
use crate::spatial::linear::{
    add_cross, columns, cross, dot, lift_vector, rotate, rotate_back, scale,
};
use crate::spatial::{Force, Motion};

/// The feature of a shape that touches.
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
    /// The lowest point of an ellipsoid about the centre: it rolls.
    Ellipsoid {
        /// The semi-axes in the body frame, m, as columns at right angles to each other. They are not parameters.
        semi_axes: Matrix3<P>,
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

/// A contact point of a body; its exact position depends on the orientation of the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPoint<P = f64> {
    /// The link of its shape.
    pub link: FrameId,
    /// The body of that link.
    pub body: BodyId,
    /// The centre in the body frame, m.
    pub center: Vector3<P>,
    /// The feature of the shape that touches.
    pub feature: Feature<P>,
}

impl<P: Scalar> ContactPoint<P> {
    /// The centre in the frame of its link in the description, m. (The frame of the body differs: its z axis is the joint axis.)
    ///
    /// # Panics
    /// If the point belongs to another robot.
    pub fn center_in_link(&self, model: &Model<P>) -> Vector3<P> {
        model.frames()[self.link.0]
            .placement
            .inverse()
            .point(&self.center)
    }
}

// An axis is not a parameter, because it is a unit vector.
numbers! { pub enum Feature {
    Corner {},
    Sphere { radius: Positive("radius", "radius of a sphere") },
    Ellipsoid { semi_axes: hidden() },
    Rim { axis: hidden(), radius: Positive("radius", "radius of a rim"), angle: kept() },
} }

numbers! { pub struct ContactPoint {
    link: kept(),
    body: kept(),
    center: Finite(["x", "y", "z"], "coordinate of a contact point"),
    feature: part(Feature),
} }

/// Maximum number of parameters of a point.
pub(crate) const POINT_NUMBERS: usize = <ContactPoint as Numbers<f64>>::COUNT;

/// Tilt of a circle against the ground (sine) above which its points follow the lowest one, and below which they are increasingly fixed to the body:
/// one milliradian. A flat circle has no lowest point, and no continuous transition to points fixed to the body stays on the circle for all tilts: at
/// some tilt the three points meet at its centre, which is too high by less than this share of the radius. With a smaller value, points move faster
/// around a circle that rocks on its face.
const FLAT: f64 = 1e-3;

/// Square of the length below which a direction is not made a unit vector, but shorter.
const LEAST_SQUARE: f64 = 1.0 / 16.0;

/// Square of the tilt of a circle against curved ground (sine) above which its lowest point uses the normal of the ground there, and below which it
/// increasingly uses that at its centre.
const STEEP_SQUARE: f64 = 0.5;

/// Tolerance on the length of an axis, as a distance from 1.
const UNIT: f64 = 1e-9;

impl<P: Scalar> ContactPoint<P> {
    /// # Panics
    /// If a parameter is out of range; the message names it.
    pub(super) fn check(&self) {
        self.check_numbers();
        if let Feature::Rim { axis, angle, .. } = self.feature {
            Domain::Finite.check("angle on a rim", angle);
            each_lane([dot(&axis, &axis)], |[square]| {
                let length = square.sqrt();
                let is_unit = (length - 1.0).abs() < UNIT;
                assert!(
                    is_unit,
                    "an axis of a rim of length {length} is not a unit vector"
                );
            });
        }
    }

    /// The radius on which it rolls: that of a sphere, of a rim whose lowest point it is, and the largest semi-axis of an ellipsoid.
    pub(super) fn rolling_radius(&self) -> Option<P> {
        match self.feature {
            Feature::Sphere { radius } => Some(radius),
            Feature::Rim {
                radius, angle: 0.0, ..
            } => Some(radius),
            // The largest semi-axis.
            Feature::Ellipsoid { semi_axes } => {
                let squares = columns(&semi_axes).map_each(|axis| dot(&axis, &axis));
                Some(squares[0].max(squares[1]).max(squares[2]).sqrt())
            }
            _ => None,
        }
    }

    /// Weight, from 0 to 1, of the normal of the ground under the point, against that under its centre, in deciding where the point is: of
    /// a rim less where it lies flat, as a small turn of the normal takes its lowest point far.
    ///
    /// * `normal` – outward normal of the ground at the centre, in the body frame
    pub(super) fn follows<T: Over<P>>(&self, normal: &Vector3<T>) -> T {
        let Feature::Rim { axis, .. } = self.feature else {
            return T::one();
        };
        let along = dot(normal, &lift_vector(&axis));
        -fading((-(along * along) + 1.0) * (1.0 / STEEP_SQUARE)) + 1.0
    }

    /// Position of the point in the body frame, for an outward normal of the ground there (both in the body frame).
    #[inline(always)]
    pub(super) fn locate<T: Over<P>>(&self, normal: &Vector3<T>) -> Vector3<T> {
        let center: Vector3<T> = lift_vector(&self.center);
        match self.feature {
            Feature::Corner => center,
            Feature::Sphere { radius } => center - scale(normal, radius.into()),
            Feature::Ellipsoid { semi_axes } => center - support(&semi_axes, normal),
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

/// From the centre of an ellipsoid with semi-axes sᵢ to its furthest point along n:  Σ sᵢ (sᵢ · n) / √(Σ (sᵢ · n)²).
fn support<P: Scalar, T: Over<P>>(semi_axes: &Matrix3<P>, n: &Vector3<T>) -> Vector3<T> {
    let along = rotate_back(semi_axes, n);
    let square = dot(&along, &along);
    let least = T::constant(f64::MIN_POSITIVE);
    let length = square.select_lt(least, T::one(), square).sqrt();
    rotate(semi_axes, &scale(&along, T::one() / length))
}

/// From the centre of a circle of radius 1 to its lowest point, turned about the axis by an angle: exact for tilts beyond [`FLAT`], and
/// never outside the circle.
fn rim_direction<T: Scalar>(axis: &Vector3<T>, normal: &Vector3<T>, angle: f64) -> Vector3<T> {
    let down = scale(axis, dot(normal, axis)) - normal;
    let hold = fading(dot(&down, &down) * (1.0 / (FLAT * FLAT)));
    let free = (-hold + 1.0) * (1.0 / FLAT);
    let d = directed(&(scale(&down, free) + scale(&perpendicular(axis), hold)));
    let (sin, cos) = angle.sin_cos();
    d * T::constant(cos) + cross(axis, &d) * T::constant(sin)
}

/// (1 − x)³ up to 1, and 0 from there on; two derivatives are continuous.
fn fading<T: Scalar>(x: T) -> T {
    let rest = -x + 1.0;
    x.select_lt(T::one(), rest * rest * rest, T::zero())
}

/// The unit vector along another one, and a shorter one where that is short; two derivatives are continuous.
fn directed<T: Scalar>(v: &Vector3<T>) -> Vector3<T> {
    let (square, least) = (dot(v, v), T::constant(LEAST_SQUARE));
    let long = T::one() / least.select_lt(square, square, least).sqrt();
    // 1 / √y by its parabola at y = 1, for y = v² / least
    let y = square * (1.0 / LEAST_SQUARE);
    let short = (y * y * 0.375 - y * 1.25 + 1.875) * (1.0 / LEAST_SQUARE.sqrt());
    scale(v, least.select_lt(square, long, short))
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
pub(crate) fn velocity_at<T: Scalar>(V: &Motion<T>, point: &Vector3<T>) -> Vector3<T> {
    add_cross(&V.linear, &V.angular, point)
}

/// Spatial force on a body, in its frame with the rotation `R_WB`, of a force (world axes, N) at a point of it.
#[inline(always)]
pub(crate) fn body_force<T: Scalar>(
    R_WB: &Matrix3<T>,
    point: &Vector3<T>,
    force: &Vector3<T>,
) -> Force<T> {
    let f_B = rotate_back(R_WB, force);
    Force::new(f_B, cross(point, &f_B))
}
