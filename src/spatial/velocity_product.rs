//! Velocity-product (Coriolis) matrix B: the derivative of the force that a body needs in its velocity.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::linear::{dot_data, fused};
use super::{Force, Inertia, Motion, SPATIAL, Transform};
use crate::scalar::{Differentiable, DualNumber, Pack, Scalar, from_each, plus_scaled};

/// The linear map from a change δω of angular velocity to that of the force on a body (or a group of bodies), where the
/// acceleration changes by δA = δV × V, as it does by turning about the world with the rest of the robot.
///
/// Row by row: the first three entries of a coordinate of the force are its derivatives in δω, the last is zero.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VelocityProductMatrix<T>(Force<Pack<T, 4>>);

impl<T: Scalar> VelocityProductMatrix<T> {
    #[inline]
    pub(crate) fn zero() -> Self {
        Self(Force::zero())
    }

    /// B δω, for two changes.
    #[inline(always)]
    pub(crate) fn times(&self, omega: &Vector3<Pack<T, 2>>) -> Force<Pack<T, 2>> {
        let row = |row: &Pack<T, 4>| dot_data(omega, &Vector3::new(row.0[0], row.0[1], row.0[2]));
        let rows = |f: &Vector3<Pack<T, 4>>| Vector3::new(row(&f.x), row(&f.y), row(&f.z));
        Force::new(rows(&self.0.linear), rows(&self.0.angular))
    }

    /// Derivative of the k-th coordinate of the force in δω: a row of B.
    #[inline(always)]
    pub(crate) fn row(&self, k: usize) -> Vector3<T> {
        let Pack([x, y, z, _]) = self.0.coordinate(k);
        Vector3::new(x, y, z)
    }

    /// Adds that of a body B which is carried: X* B Rᵀ.
    #[inline(always)]
    pub(crate) fn add_carried(&mut self, X: &Transform<T>, B: &Self) {
        let R = &X.rotation;
        let column = |k: usize| Pack([R[(0, k)], R[(1, k)], R[(2, k)], T::zero()]);
        let [x, y, z] = [column(0), column(1), column(2)];
        let row = |row: &Pack<T, 4>| fused(x, row.0[0], fused(y, row.0[1], z * row.0[2]));
        let rows = |f: &Vector3<Pack<T, 4>>| Vector3::new(row(&f.x), row(&f.y), row(&f.z));
        self.0 += X.force(&Force::new(rows(&B.0.linear), rows(&B.0.angular)));
    }
}

impl<T: Differentiable> VelocityProductMatrix<T> {
    /// Computes the matrix of a body that moves with V, by dual numbers.
    #[inline(never)]
    pub(crate) fn new(inertia: &Inertia<T>, V: &Motion<T>) -> Self {
        let mut moved = V.lift::<T::Dual<3>>();
        for k in 0..3 {
            moved.angular[k] = DualNumber::variable(V.angular[k], k);
        }
        let F = inertia.force(&moved, &moved.cross_data(V));
        let row = |x: T::Dual<3>| {
            let [x, y, z] = *x.eps();
            Pack([x, y, z, T::zero()])
        };
        Self(Force::new(F.linear.map(row), F.angular.map(row)))
    }
}

/// Velocity-product matrices of a body at the six unit velocities. At any other it is their sum, for it is linear in V: the force
/// is a form of second degree in the velocity.
#[derive(Clone, Debug)]
pub(crate) struct UnitVelocityProducts<T>([VelocityProductMatrix<T>; SPATIAL]);

impl<T: Differentiable> UnitVelocityProducts<T> {
    /// Computes the matrices of a body of this inertia.
    pub(crate) fn new(inertia: &Inertia<T>) -> Self {
        Self(from_each(|k| {
            VelocityProductMatrix::new(inertia, &Motion::basis(k))
        }))
    }

    /// The matrix where the body moves with V.
    #[inline(always)]
    pub(crate) fn at(&self, V: &Motion<T>) -> VelocityProductMatrix<T> {
        let mut rows = [Pack([T::zero(); 4]); SPATIAL];
        let V = V.to_array();
        for k in 0..SPATIAL {
            let unit = self.0[k].0.to_array();
            for i in 0..SPATIAL {
                rows[i] = Pack(plus_scaled(&rows[i].0, V[k], &unit[i].0));
            }
        }
        VelocityProductMatrix(Force::from_array(rows))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spatial::{Quaternion, Symmetric3};
    use crate::tests::{ROUNDING, SAME_ALGEBRA};
    use approx::assert_relative_eq;
    use nalgebra::SMatrix;

    fn inertia() -> Inertia<f64> {
        let about_com = Symmetric3::new(0.5, 0.02, -0.03, 0.4, 0.01, 0.3);
        Inertia::from_com(2.5, &Vector3::new(0.1, -0.2, 0.3), &about_com)
    }

    fn velocity() -> Motion<f64> {
        Motion::from_array([0.3, -1.0, 0.7, 2.0, 0.1, -0.4])
    }

    fn matrix(B: &VelocityProductMatrix<f64>) -> SMatrix<f64, SPATIAL, 3> {
        SMatrix::from_fn(|row, column| B.row(row)[column])
    }

    #[test]
    fn the_sum_of_those_at_unit_velocities_equals_the_difference_quotient() {
        let (I, V) = (inertia(), velocity());
        let A = Motion::from_array([1.0, 2.0, -3.0, 0.5, -0.7, 0.2]);
        let B = matrix(&UnitVelocityProducts::new(&I).at(&V));
        for k in 0..3 {
            let h = 1e-3;
            let at = |h: f64| {
                let dV = Motion::basis(3 + k) * h;
                I.force(&(V + dV), &(A + dV.cross(&V)))
            };
            // Of second degree in h, so that central differences are exact.
            let change = at(h) - at(-h);
            for row in 0..SPATIAL {
                assert_relative_eq!(
                    B[(row, k)],
                    change.coordinate(row) / (2.0 * h),
                    epsilon = 1e-11
                );
            }
        }
    }

    #[test]
    fn a_body_seen_from_elsewhere_has_that_of_its_inertia_there() {
        let rotation = Quaternion::exp(&Vector3::new(0.4, -1.0, 0.6)).to_matrix();
        let X = Transform::new(rotation, Vector3::new(1.0, -2.0, 0.5));
        let (I, V) = (inertia(), velocity());
        let mut carried = VelocityProductMatrix::zero();
        carried.add_carried(&X, &UnitVelocityProducts::new(&I).at(&V));
        let there = UnitVelocityProducts::new(&X.inertia(&I)).at(&X.motion(&V));
        assert_relative_eq!(matrix(&carried), matrix(&there), epsilon = SAME_ALGEBRA);
    }

    #[test]
    fn two_changes_at_once_equal_rows_times_each() {
        let B = UnitVelocityProducts::new(&inertia()).at(&velocity());
        let omega = Vector3::new(Pack([1.0, 0.3]), Pack([-2.0, 0.1]), Pack([0.5, 4.0]));
        let F = B.times(&omega);
        for (row, lane) in (0..SPATIAL).flat_map(|row| [(row, 0), (row, 1)]) {
            let expected = B.row(row).dot(&omega.map(|x| x.0[lane]));
            assert_relative_eq!(
                F.coordinate(row).0[lane],
                expected,
                epsilon = 10.0 * ROUNDING
            );
        }
    }
}
