//! Norms and reciprocals that stay finite, with their derivatives, where a vector vanishes.

use nalgebra::Vector3;

use crate::scalar::Scalar;
use crate::spatial::linear::{dot, scale};

/// Squares of lengths below count as zero: (10⁻¹⁵⁰)², above where doubles lose digits.
const SQUARE_OF_NOTHING: f64 = 1e-300;

/// Part of two lengths that their difference must have to be more than their rounding.
pub(super) const ROUNDING: f64 = 1e-14;

/// The norm of a vector; zero, without derivatives, where it vanishes.
pub(super) fn safe_norm<T: Scalar>(v: &Vector3<T>) -> T {
    let square = dot(v, v);
    let nothing = T::constant(SQUARE_OF_NOTHING);
    let safe = square.select_lt(nothing, T::one(), square);
    square.select_lt(nothing, T::zero(), safe.sqrt())
}

/// 1 / x; zero where x vanishes.
pub(super) fn reciprocal_or_zero<T: Scalar>(x: T) -> T {
    reciprocal_above(x, T::zero())
}

/// 1 / x; zero where the magnitude of x is not above a bound, or vanishes.
pub(super) fn reciprocal_above<T: Scalar>(x: T, least: T) -> T {
    let square = x * x;
    let nothing = least * least + SQUARE_OF_NOTHING;
    let safe = square.select_lt(nothing, T::one(), x);
    square.select_lt(nothing, T::zero(), T::one() / safe)
}

/// The unit vector along a vector; another one where it vanishes, or is shorter than a part `ROUNDING` of what it is the difference of.
///
/// * `size` – square of the length of what the vector is the difference of
pub(super) fn normalized_or<T: Scalar>(v: &Vector3<T>, size: T, other: &Vector3<T>) -> Vector3<T> {
    let square = dot(v, v);
    let nothing = size * (ROUNDING * ROUNDING) + SQUARE_OF_NOTHING;
    let safe = square.select_lt(nothing, T::one(), square);
    let unit = scale(v, T::one() / safe.sqrt());
    Vector3::from_fn(|k, _| square.select_lt(nothing, other[k], unit[k]))
}

/// Two unit vectors across a unit vector and each other, right-handed with it.
pub(super) fn plane_across(n: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let x = n.cross(&Vector3::ith(n.iamin(), 1.0)).normalize();
    [x, n.cross(&x)]
}

/// The part of a vector across a direction u of any length.
pub(super) fn rejected<T: Scalar>(v: &Vector3<T>, u: &Vector3<T>) -> Vector3<T> {
    v - scale(u, dot(u, v) * reciprocal_or_zero(dot(u, u)))
}
