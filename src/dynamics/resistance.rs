//! What joints resist an acceleration with by themselves: a diagonal beside the mass matrix.

use crate::scalar::Scalar;

/// Resistance of each coordinate, kg·m² or kg.
pub(super) trait Resistance<T> {
    /// x with the resistance of a coordinate.
    fn added(&self, coordinate: usize, x: T) -> T;
}

/// No resistance, which costs nothing.
pub(super) struct Free;

impl<T> Resistance<T> for Free {
    #[inline(always)]
    fn added(&self, _: usize, x: T) -> T {
        x
    }
}

impl<T: Scalar> Resistance<T> for [T] {
    #[inline(always)]
    fn added(&self, coordinate: usize, x: T) -> T {
        x + self[coordinate]
    }
}
