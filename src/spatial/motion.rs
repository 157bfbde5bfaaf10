//! Spatial motions: velocities and accelerations of rigid bodies.

use std::ops::{Add, AddAssign, Mul, Neg, Sub};

use nalgebra::Vector3;

use super::linear::{add_cross, add_cross_data, cross, cross_data, dot, lift_vector, zero};
use super::vector::spatial_vector;
use super::{Force, SPATIAL};
use crate::scalar::{Additive, Cast, Linear, Over, Scalar};

/// A spatial velocity or acceleration, `[linear; angular]`.
///
/// The linear part is the velocity (m/s) of the body-fixed point that coincides with the origin of the frame of
/// expression, the angular part the angular velocity (rad/s).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion<T> {
    /// Velocity of the point at the origin, m/s (acceleration: m/s²).
    pub linear: Vector3<T>,
    /// Angular velocity, rad/s (acceleration: rad/s²).
    pub angular: Vector3<T>,
}

spatial_vector!(Motion);

impl<T: Additive> Motion<T> {
    /// Mutable access to the k-th coordinate.
    ///
    /// # Panics
    /// If `k ≥ 6`.
    #[inline(always)]
    pub(crate) fn coordinate_mut(&mut self, k: usize) -> &mut T {
        if k < 3 {
            &mut self.linear[k]
        } else {
            &mut self.angular[k - 3]
        }
    }

    /// [`cross`](Self::cross), the right factor may be model data.
    #[inline(always)]
    pub(crate) fn cross_data<P: Scalar>(&self, other: &Motion<P>) -> Self
    where
        T: Linear<P>,
    {
        Self::new(
            add_cross_data(
                &cross_data(&self.angular, &other.linear),
                &self.linear,
                &other.angular,
            ),
            cross_data(&self.angular, &other.angular),
        )
    }
}

impl<T: Scalar> Motion<T> {
    /// The k-th coordinate direction in the order `[linear; angular]`.
    ///
    /// # Panics
    /// If `k ≥ 6`.
    #[inline]
    pub(crate) fn basis(k: usize) -> Self {
        let mut out = Self::zero();
        *out.coordinate_mut(k) = T::one();
        out
    }

    /// The rate of change of `other` if it is fixed in a frame that moves with `self`:
    /// V × U = (ω × u + v × w; ω × w) for V = (v; ω), U = (u; w) [Featherstone 2008, 2.29].
    #[inline(always)]
    pub fn cross(&self, other: &Self) -> Self {
        self.cross_data::<T>(other)
    }

    /// The rate of change of a force fixed in a frame that moves with `self`:
    /// V ×* F = (ω × f; ω × n + v × f) for F = (f; n) [Featherstone 2008, 2.30].
    #[inline(always)]
    pub fn cross_force(&self, force: &Force<T>) -> Force<T> {
        Force::new(
            cross(&self.angular, &force.linear),
            add_cross(
                &cross(&self.angular, &force.angular),
                &self.linear,
                &force.linear,
            ),
        )
    }

    /// The power of a force on a body with this velocity, in W: f · v + n · ω.
    #[inline(always)]
    pub fn power(&self, force: &Force<T>) -> T {
        dot(&self.linear, &force.linear) + dot(&self.angular, &force.angular)
    }

    /// Lifts the motion to another scalar.
    #[inline]
    pub(crate) fn lift<S: Over<T>>(&self) -> Motion<S> {
        Motion {
            linear: lift_vector(&self.linear),
            angular: lift_vector(&self.angular),
        }
    }
}

impl<P: Scalar> Cast<P> for Motion<P> {
    type To<Q: Scalar> = Motion<Q>;

    fn cast<Q: Over<P>>(&self) -> Motion<Q> {
        self.lift()
    }
}

impl<T: Scalar> Mul<T> for Motion<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: T) -> Self {
        Self::new(self.linear * factor, self.angular * factor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::ROUNDING;
    use approx::assert_relative_eq;

    fn motion(x: [f64; 6]) -> Motion<f64> {
        Motion::from_array(x)
    }

    const V: [f64; 6] = [0.3, -1.0, 0.7, 2.0, 0.1, -0.4];
    const U: [f64; 6] = [1.3, 0.2, -0.6, -1.0, 0.9, 0.5];
    const W: [f64; 6] = [-0.3, 0.8, 0.4, 0.7, -1.9, 1.1];

    #[test]
    fn motion_cross_product_obeys_the_jacobi_identity() {
        let (v, u, w) = (motion(V), motion(U), motion(W));
        let sum = v.cross(&u.cross(&w)) + u.cross(&w.cross(&v)) + w.cross(&v.cross(&u));
        assert!(sum.to_array().iter().all(|x| x.abs() < 10.0 * ROUNDING));
        assert!(v.cross(&v).to_array().iter().all(|x| x.abs() < ROUNDING));
    }

    // d/dt (F · U) = 0 for both fixed in a moving frame: (V ×* F) · U = −F · (V × U).
    #[test]
    fn force_cross_product_is_minus_the_transpose_of_the_motion_one() {
        let (v, u) = (motion(V), motion(U));
        let f = Force::from_array(W);
        assert_relative_eq!(
            u.power(&v.cross_force(&f)),
            -v.cross(&u).power(&f),
            epsilon = 10.0 * ROUNDING
        );
    }

    #[test]
    fn coordinates_follow_the_linear_first_order() {
        let v = motion([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!(v.linear, Vector3::new(1.0, 2.0, 3.0));
        assert_eq!(v.to_array(), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!(Motion::<f64>::basis(4).angular.y, 1.0);
    }
}
