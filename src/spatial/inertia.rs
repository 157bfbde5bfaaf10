//! Rigid-body inertia about the origin of the body frame.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

mod polyhedron;
mod solids;

use std::ops::Add;

use nalgebra::{Matrix3, Matrix6, Vector3};

use super::linear::{cross_data, lift_vector, rotate, scale, scale_add_data, sub_cross_data};
use super::{Force, Motion, Symmetric3};
use crate::numbers::numbers;
use crate::scalar::{Cast, Linear, Over, Scalar};

/// The inertia of a rigid body B in its frame, about the frame's origin.
///
/// The dynamics are *linear* in mass, first moment and rotational inertia.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertia<P> {
    /// Mass m, kg.
    pub mass: P,
    /// First moment h = m c of the centre of mass c, kg·m.
    pub first_moment: Vector3<P>,
    /// Rotational inertia about the origin of the frame, kg·m².
    pub rotational: Symmetric3<P>,
}

// In the order of `to_parameters`.
numbers! { struct Inertia {
    mass: NotNegative("mass"),
    first_moment: Finite(["hx", "hy", "hz"], "parameter of an inertia"),
    rotational: part(Symmetric3),
} }

impl<P: Scalar> Inertia<P> {
    /// Zero inertia: no mass.
    #[inline]
    pub fn zero() -> Self {
        Self {
            mass: P::zero(),
            first_moment: Vector3::zeros(),
            rotational: Symmetric3::zero(),
        }
    }

    /// Makes a spatial inertia from mass, centre of mass `c` in the body frame, and rotational inertia about the centre
    /// of mass with the body frame's axes.
    ///
    /// Parallel axes: J = J about the centre of mass − m \[c\]².
    pub fn from_com(mass: P, com: &Vector3<P>, about_com: &Symmetric3<P>) -> Self {
        let first_moment = scale(com, mass);
        let shift = Symmetric3::parallel_axis(&scale(com, P::constant(0.5)), &first_moment);
        Self {
            mass,
            first_moment,
            rotational: *about_com + shift,
        }
    }

    /// The centre of mass in the body frame, m. Not finite for zero mass.
    #[inline]
    pub fn com(&self) -> Vector3<P> {
        scale(&self.first_moment, P::one() / self.mass)
    }

    /// The rotational inertia about the centre of mass, kg·m². Not finite for zero mass.
    pub fn about_com(&self) -> Symmetric3<P> {
        self.rotational
            - Symmetric3::parallel_axis(&scale(&self.com(), P::constant(0.5)), &self.first_moment)
    }

    /// The momentum of the body moving with V:  I V = (m v + ω × h; J ω + h × v).
    #[inline(always)]
    pub fn times<T: Linear<P>>(&self, V: &Motion<T>) -> Force<T> {
        Force::new(
            scale_add_data(
                &V.linear,
                self.mass,
                &cross_data(&V.angular, &self.first_moment),
            ),
            sub_cross_data(
                &self.rotational.times(&V.angular),
                &V.linear,
                &self.first_moment,
            ),
        )
    }

    /// The force that a body needs for its motion:  F = I A + V ×* I V, by Newton and Euler
    /// [Featherstone 2008, chapter 2].
    #[inline(always)]
    pub(crate) fn force<T: Over<P>>(&self, V: &Motion<T>, A: &Motion<T>) -> Force<T> {
        self.times(A) + V.cross_force(&self.times(V))
    }

    /// The k-th column of the 6 × 6 matrix, rows and columns `[linear; angular]`.
    ///
    /// # Panics
    /// If `k ≥ 6`.
    #[inline(always)]
    pub(crate) fn column(&self, k: usize) -> Force<P> {
        match k {
            2 => self.column_linear_z(),
            5 => self.column_angular_z(),
            _ => self.times::<P>(&Motion::basis(k)),
        }
    }

    /// The 6 × 6 matrix, rows and columns `[linear; angular]`.
    pub fn to_matrix(&self) -> Matrix6<P> {
        Matrix6::from_fn(|row, column| self.column(column).coordinate(row))
    }

    /// The column of the z axis of rotation, (ê × h; J ê): the one that revolute joints need.
    #[inline(always)]
    fn column_angular_z(&self) -> Force<P> {
        let h = &self.first_moment;
        Force::new(
            Vector3::new(-h.y, h.x, P::zero()),
            self.rotational.column(2),
        )
    }

    /// The column of the z axis of translation, (m ê; h × ê): the one that prismatic joints need.
    #[inline(always)]
    fn column_linear_z(&self) -> Force<P> {
        let h = &self.first_moment;
        Force::new(
            Vector3::new(P::zero(), P::zero(), self.mass),
            Vector3::new(h.y, -h.x, P::zero()),
        )
    }

    /// Inertia in a frame that is turned by R and whose origin sees the body's at `p`: `I_A` from `I_B` and the pose of
    /// B in A.
    #[inline(always)]
    pub(crate) fn moved(&self, r: &Matrix3<P>, p: &Vector3<P>) -> Self {
        let h = rotate::<P, P>(r, &self.first_moment);
        // J_A = R J Rᵀ − [p][h] − [h][p] − m [p]²
        let moment = scale_add_data::<P, P>(p, self.mass * 0.5, &h);
        Self {
            mass: self.mass,
            first_moment: scale_add_data::<P, P>(p, self.mass, &h),
            rotational: self.rotational.rotated(r) + Symmetric3::parallel_axis(p, &moment),
        }
    }

    /// The inertia of a body of the same shape with its density scaled.
    pub fn scaled(&self, factor: P) -> Self {
        let j = &self.rotational;
        let rotational = Symmetric3::new(
            j.xx * factor,
            j.xy * factor,
            j.xz * factor,
            j.yy * factor,
            j.yz * factor,
            j.zz * factor,
        );
        Self {
            mass: self.mass * factor,
            first_moment: scale(&self.first_moment, factor),
            rotational,
        }
    }

    /// Lifts the inertia to another scalar.
    #[inline(always)]
    pub(crate) fn lift<T: Over<P>>(&self) -> Inertia<T> {
        Inertia {
            mass: <T as From<P>>::from(self.mass),
            first_moment: lift_vector(&self.first_moment),
            rotational: self.rotational.lift(),
        }
    }
}

impl<P: Scalar> Cast<P> for Inertia<P> {
    type To<Q: Scalar> = Inertia<Q>;

    fn cast<Q: Over<P>>(&self) -> Inertia<Q> {
        self.lift()
    }
}

impl<P: Scalar> Add for Inertia<P> {
    type Output = Self;
    /// The inertia of two bodies moving as one, both about the same origin.
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self {
            mass: self.mass + other.mass,
            first_moment: self.first_moment + other.first_moment,
            rotational: self.rotational + other.rotational,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spatial::{Quaternion, SPATIAL, Transform};
    use crate::tests::{ROUNDING, SAME_ALGEBRA};
    use approx::assert_relative_eq;

    fn inertia() -> Inertia<f64> {
        Inertia::from_com(
            2.5,
            &Vector3::new(0.1, -0.2, 0.3),
            &Symmetric3::new(0.5, 0.02, -0.03, 0.4, 0.01, 0.3),
        )
    }

    fn velocity() -> Motion<f64> {
        Motion::from_array([0.3, -1.0, 0.7, 2.0, 0.1, -0.4])
    }

    // p = m (v + ω × c);  L_origin = J_com ω + c × p
    #[test]
    fn momentum_equals_newton_euler_about_the_centre_of_mass() {
        let (i, V) = (inertia(), velocity());
        let momentum = i.times(&V);
        let p = (V.linear + V.angular.cross(&i.com())) * i.mass;
        let l = i.about_com().times(&V.angular) + i.com().cross(&p);
        assert_relative_eq!(momentum.linear, p, epsilon = 10.0 * ROUNDING);
        assert_relative_eq!(momentum.angular, l, epsilon = 10.0 * ROUNDING);
    }

    #[test]
    fn kinetic_energy_does_not_depend_on_the_frame() {
        let X_AB = Transform::new(
            Quaternion::exp(&Vector3::new(0.4, -1.0, 0.6)).to_matrix(),
            Vector3::new(1.0, -2.0, 0.5),
        );
        let (I_B, V_B) = (inertia(), velocity());
        let (I_A, V_A) = (X_AB.inertia(&I_B), X_AB.motion(&V_B));
        assert_relative_eq!(
            V_A.power(&I_A.times(&V_A)),
            V_B.power(&I_B.times(&V_B)),
            epsilon = SAME_ALGEBRA
        );
        let (F_A, F_B) = (I_A.times(&V_A), X_AB.force(&I_B.times(&V_B)));
        assert_relative_eq!(F_A.linear, F_B.linear, epsilon = 1e-13);
        assert_relative_eq!(F_A.angular, F_B.angular, epsilon = 1e-13);
    }

    #[test]
    fn columns_equal_products_with_the_basis() {
        let i = inertia();
        for k in 0..SPATIAL {
            assert_eq!(i.column(k), i.times::<f64>(&Motion::basis(k)));
        }
    }
}
