//! Spatial forces (wrenches) and momenta.

use std::ops::{Add, AddAssign, Neg, Sub};

use nalgebra::Vector3;

use super::SPATIAL;
use super::linear::{lift_vector, zero};
use super::vector::spatial_vector;
use crate::scalar::{Additive, Cast, Over, Scalar};

/// A spatial force or momentum, `[linear; angular]`.
///
/// The linear part is the force (N; momentum: kg·m/s), the angular part the moment about the origin of the frame of
/// expression (N·m; kg·m²/s).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Force<T> {
    /// Force, N (momentum: kg·m/s).
    pub linear: Vector3<T>,
    /// Moment about the origin, N·m (momentum: kg·m²/s).
    pub angular: Vector3<T>,
}

spatial_vector!(Force);

impl<T: Additive> Force<T> {
    /// Mutable references to the six coordinates `[linear; angular]`.
    #[inline(always)]
    pub(crate) fn entries_mut(&mut self) -> [&mut T; SPATIAL] {
        let [[fx, fy, fz]] = &mut self.linear.data.0;
        let [[nx, ny, nz]] = &mut self.angular.data.0;
        [fx, fy, fz, nx, ny, nz]
    }
}

impl<T: Scalar> Force<T> {
    /// Multiplies the force by `s`.
    #[inline(always)]
    pub(crate) fn scaled(&self, s: T) -> Self {
        Self::new(self.linear * s, self.angular * s)
    }

    /// Lifts the force to another scalar.
    #[inline(always)]
    pub(crate) fn lift<S: Over<T>>(&self) -> Force<S> {
        Force::new(lift_vector(&self.linear), lift_vector(&self.angular))
    }
}

impl<P: Scalar> Cast<P> for Force<P> {
    type To<Q: Scalar> = Force<Q>;

    fn cast<Q: Over<P>>(&self) -> Force<Q> {
        self.lift()
    }
}
