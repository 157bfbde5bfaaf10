//! Articulated-body inertia: the apparent inertia of a body with a mechanism attached.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::ops::Add;

use nalgebra::{Matrix3, Vector3};

use super::linear::{
    add_cross, columns, from_columns, from_rows, rotate, rotate_back, rows, scale_add_data, sum,
};
use super::{Force, Inertia, Motion, Symmetric3, Transform};
use crate::scalar::{Over, Scalar};

/// A symmetric 6 × 6 inertia in blocks: F = I V with f = M v + H ω, n = Hᵀ v + J ω.
///
/// # References
/// [Featherstone 2008, section 7.1].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArticulatedInertia<T> {
    /// Block M from linear velocity to force, kg.
    pub mass: Symmetric3<T>,
    /// Block H from angular velocity to force, kg·m.
    pub coupling: Matrix3<T>,
    /// Block J from angular velocity to moment, kg·m².
    pub rotational: Symmetric3<T>,
}

/// Numbers of a symmetric 6 × 6 matrix.
const ARTICULATED_ENTRIES: usize = 21;

impl<T: Scalar> ArticulatedInertia<T> {
    /// The articulated inertia of a body that carries nothing: M = m 1, `H = −[h]`.
    #[inline(always)]
    pub(crate) fn rigid(body: &Inertia<T>) -> Self {
        let (h, zero) = (body.first_moment, T::zero());
        Self {
            mass: Symmetric3::scalar(body.mass),
            coupling: Matrix3::new(zero, h.z, -h.y, -h.z, zero, h.x, h.y, -h.x, zero),
            rotational: body.rotational,
        }
    }

    /// Becomes [`rigid`](Self::rigid), number by number where it lies: as a whole, wide numbers would go through memory
    /// twice.
    #[inline(always)]
    pub(crate) fn set_rigid<P: Scalar>(&mut self, body: &Inertia<P>)
    where
        T: Over<P>,
    {
        let (m, h, J) = (body.mass.into(), &body.first_moment, &body.rotational);
        let [x, y, z]: [T; 3] = [h.x.into(), h.y.into(), h.z.into()];
        let (to, zero) = (&mut self.mass, T::zero());
        (to.xx, to.xy, to.xz) = (m, zero, zero);
        (to.yy, to.yz, to.zz) = (m, zero, m);
        let to = &mut self.coupling;
        (to.m11, to.m12, to.m13) = (zero, z, -y);
        (to.m21, to.m22, to.m23) = (-z, zero, x);
        (to.m31, to.m32, to.m33) = (y, -x, zero);
        let to = &mut self.rotational;
        (to.xx, to.xy, to.xz) = (J.xx.into(), J.xy.into(), J.xz.into());
        (to.yy, to.yz, to.zz) = (J.yy.into(), J.yz.into(), J.zz.into());
    }

    /// M, H row by row, J.
    #[inline(always)]
    pub(crate) fn entries(&self) -> [&T; ARTICULATED_ENTRIES] {
        let (m, h, j) = (&self.mass, &self.coupling, &self.rotational);
        [
            &m.xx, &m.xy, &m.xz, &m.yy, &m.yz, &m.zz, &h.m11, &h.m12, &h.m13, &h.m21, &h.m22,
            &h.m23, &h.m31, &h.m32, &h.m33, &j.xx, &j.xy, &j.xz, &j.yy, &j.yz, &j.zz,
        ]
    }

    /// Mutable references to the entries: M, H row by row, J.
    #[inline(always)]
    pub(crate) fn entries_mut(&mut self) -> [&mut T; ARTICULATED_ENTRIES] {
        let (m, h, j) = (&mut self.mass, &mut self.coupling, &mut self.rotational);
        let [[h11, h21, h31], [h12, h22, h32], [h13, h23, h33]] = &mut h.data.0;
        [
            &mut m.xx, &mut m.xy, &mut m.xz, &mut m.yy, &mut m.yz, &mut m.zz, h11, h12, h13, h21,
            h22, h23, h31, h32, h33, &mut j.xx, &mut j.xy, &mut j.xz, &mut j.yy, &mut j.yz,
            &mut j.zz,
        ]
    }

    /// Makes an articulated inertia from M, H row by row, J.
    #[inline(always)]
    pub(crate) fn from_entries(x: [T; ARTICULATED_ENTRIES]) -> Self {
        Self {
            mass: Symmetric3::new(x[0], x[1], x[2], x[3], x[4], x[5]),
            coupling: Matrix3::new(x[6], x[7], x[8], x[9], x[10], x[11], x[12], x[13], x[14]),
            rotational: Symmetric3::new(x[15], x[16], x[17], x[18], x[19], x[20]),
        }
    }

    /// Computes the force I V of an acceleration V.
    #[inline(always)]
    pub(crate) fn times(&self, V: &Motion<T>) -> Force<T> {
        Force::new(
            self.mass.times::<T>(&V.linear) + rotate(&self.coupling, &V.angular),
            rotate_back(&self.coupling, &V.linear) + self.rotational.times::<T>(&V.angular),
        )
    }

    /// I V for a motion without components along and about z.
    #[inline(always)]
    pub(crate) fn times_in_plane(&self, V: &Motion<T>) -> Force<T> {
        let (h, m, j) = (&self.coupling, &self.mass, &self.rotational);
        Force::new(
            Vector3::new(
                row_in_plane(V, m.xx, m.xy, h.m11, h.m12),
                row_in_plane(V, m.xy, m.yy, h.m21, h.m22),
                row_in_plane(V, m.xz, m.yz, h.m31, h.m32),
            ),
            Vector3::new(
                row_in_plane(V, h.m11, h.m21, j.xx, j.xy),
                row_in_plane(V, h.m12, h.m22, j.xy, j.yy),
                row_in_plane(V, h.m13, h.m23, j.xz, j.yz),
            ),
        )
    }

    /// The k-th column, rows and columns `[linear; angular]`.
    ///
    /// # Panics
    /// If `k ≥ 6`.
    #[inline(always)]
    pub(crate) fn column(&self, k: usize) -> Force<T> {
        let h = &self.coupling;
        if k < 3 {
            Force::new(
                self.mass.column(k),
                Vector3::new(h[(k, 0)], h[(k, 1)], h[(k, 2)]),
            )
        } else {
            let k = k - 3;
            Force::new(
                Vector3::new(h[(0, k)], h[(1, k)], h[(2, k)]),
                self.rotational.column(k),
            )
        }
    }

    /// I − U Wᵀ: removes a direction in which a joint gives way. The sum over a joint's directions must be symmetric.
    #[inline(always)]
    pub(crate) fn minus_outer(&self, U: &Force<T>, W: &Force<T>) -> Self {
        let (a, b) = (&U.linear, &W.angular);
        let [x, y, z] = columns(&self.coupling);
        Self {
            mass: self.mass.minus_outer(&U.linear, &W.linear),
            coupling: from_columns(
                &scale_add_data::<T, T>(a, -b.x, &x),
                &scale_add_data::<T, T>(a, -b.y, &y),
                &scale_add_data::<T, T>(a, -b.z, &z),
            ),
            rotational: self.rotational.minus_outer(&U.angular, &W.angular),
        }
    }

    /// Transforms the inertia to frame A, given in frame B: X* I X⁻¹.
    #[inline(always)]
    pub(crate) fn moved(&self, X_AB: &Transform<T>) -> Self {
        let (r, p) = (&X_AB.rotation, &X_AB.translation);
        let mass = self.mass.rotated(r);
        let rotational = self.rotational.rotated(r);
        // H' = R H Rᵀ, row by row: R (Hᵀ rᵢ) with the rows rᵢ of R
        let [x, y, z] = rows(r);
        let h = [
            rotate(r, &rotate_back(&self.coupling, &x)),
            rotate(r, &rotate_back(&self.coupling, &y)),
            rotate(r, &rotate_back(&self.coupling, &z)),
        ];
        // H_A = H' − M_A [p], whose rows are those of H' plus p × (column of M_A)
        let coupling = [
            add_cross(&h[0], p, &mass.column(0)),
            add_cross(&h[1], p, &mass.column(1)),
            add_cross(&h[2], p, &mass.column(2)),
        ];
        // J_A = R J Rᵀ + ([p] H')ᵀ + [p] H_A
        let rotational = rotational.plus_cross_transposed(p, &h);
        Self {
            mass,
            coupling: from_rows(&coupling),
            rotational: rotational.plus_cross(p, &coupling),
        }
    }
}

/// A row of an inertia, the entries along and about x and y, times a motion without components along and about z.
#[inline(always)]
fn row_in_plane<T: Scalar>(V: &Motion<T>, a: T, b: T, c: T, d: T) -> T {
    let (v, w) = (&V.linear, &V.angular);
    v.x.mul_add(a, v.y * b) + w.x.mul_add(c, w.y * d)
}

impl<T: Scalar> Add for ArticulatedInertia<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self {
            mass: self.mass + other.mass,
            coupling: sum(&self.coupling, &other.coupling),
            rotational: self.rotational + other.rotational,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spatial::Quaternion;
    use crate::tests::{ROUNDING, SAME_ALGEBRA};
    use approx::assert_relative_eq;

    fn pose() -> Transform<f64> {
        Transform::new(
            Quaternion::exp(&Vector3::new(0.4, -1.0, 0.6)).to_matrix(),
            Vector3::new(1.0, -2.0, 0.5),
        )
    }

    fn body() -> Inertia<f64> {
        Inertia::from_com(
            2.5,
            &Vector3::new(0.1, -0.2, 0.3),
            &Symmetric3::new(0.5, 0.02, -0.03, 0.4, 0.01, 0.3),
        )
    }

    fn assert_same(a: &ArticulatedInertia<f64>, b: &ArticulatedInertia<f64>) {
        assert_relative_eq!(a.mass.to_matrix(), b.mass.to_matrix(), epsilon = 1e-13);
        assert_relative_eq!(a.coupling, b.coupling, epsilon = 1e-13);
        assert_relative_eq!(
            a.rotational.to_matrix(),
            b.rotational.to_matrix(),
            epsilon = 1e-13
        );
    }

    #[test]
    fn moved_rigid_inertia_equals_rigid_inertia_of_the_moved_body() {
        assert_same(
            &ArticulatedInertia::rigid(&body()).moved(&pose()),
            &ArticulatedInertia::rigid(&pose().inertia(&body())),
        );
    }

    // X* (I (X⁻¹ V)) for an inertia that is not one of a rigid body.
    #[test]
    fn moved_inertia_maps_motions_as_the_original_does() {
        let U = Force::from_array([0.3, -1.0, 0.7, 2.0, 0.1, -0.4]);
        let I_B = ArticulatedInertia::rigid(&body()).minus_outer(&U, &U.scaled(0.1));
        let V_A = Motion::from_array([1.3, 0.2, -0.6, -1.0, 0.9, 0.5]);
        let expected = pose().force(&I_B.times(&pose().motion_inverse(&V_A)));
        let actual = I_B.moved(&pose()).times(&V_A);
        assert_relative_eq!(actual.linear, expected.linear, epsilon = SAME_ALGEBRA);
        assert_relative_eq!(actual.angular, expected.angular, epsilon = SAME_ALGEBRA);
    }

    #[test]
    fn product_with_a_motion_in_the_plane_equals_the_full_product() {
        let U = Force::from_array([0.3, -1.0, 0.7, 2.0, 0.1, -0.4]);
        let inertia = ArticulatedInertia::rigid(&body()).minus_outer(&U, &U.scaled(0.1));
        let V = Motion::from_array([1.3, 0.2, 0.0, -1.0, 0.9, 0.0]);
        let difference = inertia.times_in_plane(&V) - inertia.times(&V);
        assert!(
            difference
                .to_array()
                .iter()
                .all(|x| x.abs() < 10.0 * ROUNDING),
            "{difference:?}"
        );
    }

    #[test]
    fn columns_equal_products_with_the_basis() {
        let U = Force::from_array([0.3, -1.0, 0.7, 2.0, 0.1, -0.4]);
        let inertia = ArticulatedInertia::rigid(&body()).minus_outer(&U, &U.scaled(0.1));
        for k in 0..6 {
            assert_eq!(inertia.column(k), inertia.times(&Motion::basis(k)));
        }
    }
}
