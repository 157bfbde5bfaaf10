//! Spatial forces (wrenches) and momenta.

use std::ops::{Add, AddAssign, Neg, Sub};

use nalgebra::Vector3;

use super::SPATIAL;
use super::linear::{lift_vector, zero};
use crate::scalar::{Additive, Over, Scalar};

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

impl<T: Additive> Force<T> {
    /// Makes a spatial force from force and moment.
    #[inline(always)]
    pub fn new(linear: Vector3<T>, angular: Vector3<T>) -> Self {
        Self { linear, angular }
    }

    /// Zero force.
    #[inline(always)]
    pub fn zero() -> Self {
        Self::new(zero(), zero())
    }

    /// The k-th coordinate in the order `[linear; angular]`.
    ///
    /// # Panics
    /// If `k ≥ 6`.
    #[inline(always)]
    pub fn coordinate(&self, k: usize) -> T {
        if k < 3 {
            self.linear[k]
        } else {
            self.angular[k - 3]
        }
    }

    /// Coordinates `[linear; angular]`.
    #[inline(always)]
    pub fn to_array(&self) -> [T; SPATIAL] {
        let (l, a) = (&self.linear, &self.angular);
        [l.x, l.y, l.z, a.x, a.y, a.z]
    }

    /// Coordinates `[linear; angular]` where they lie.
    #[inline(always)]
    pub(crate) fn entries(&self) -> [&T; SPATIAL] {
        let (l, a) = (&self.linear, &self.angular);
        [&l.x, &l.y, &l.z, &a.x, &a.y, &a.z]
    }

    /// Mutable references to the six coordinates `[linear; angular]`.
    #[inline(always)]
    pub(crate) fn entries_mut(&mut self) -> [&mut T; SPATIAL] {
        let [[fx, fy, fz]] = &mut self.linear.data.0;
        let [[nx, ny, nz]] = &mut self.angular.data.0;
        [fx, fy, fz, nx, ny, nz]
    }

    /// Makes a spatial force from its six coordinates `[linear; angular]`.
    #[inline(always)]
    pub fn from_array(x: [T; SPATIAL]) -> Self {
        Self::new(
            Vector3::new(x[0], x[1], x[2]),
            Vector3::new(x[3], x[4], x[5]),
        )
    }
}

impl<T: Scalar> Force<T> {
    /// Multiplies the force by `s`.
    #[inline(always)]
    pub fn scaled(&self, s: T) -> Self {
        Self::new(self.linear * s, self.angular * s)
    }

    /// Lifts the force to another scalar.
    #[inline(always)]
    pub fn lift<S: Over<T>>(&self) -> Force<S> {
        Force::new(lift_vector(&self.linear), lift_vector(&self.angular))
    }
}

impl<T: Additive> Add for Force<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self::new(self.linear + other.linear, self.angular + other.angular)
    }
}

impl<T: Additive> AddAssign for Force<T> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<T: Additive> Sub for Force<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self::new(self.linear - other.linear, self.angular - other.angular)
    }
}

impl<T: Additive> Neg for Force<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(-self.linear, -self.angular)
    }
}
