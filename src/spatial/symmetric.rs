//! Symmetric 3 × 3 matrices with six entries.

use std::ops::{Add, Sub};

use nalgebra::{Matrix3, Vector3};

use super::linear::{dot, fused, rows};
use crate::numbers::numbers;
use crate::scalar::{Cast, Linear, Over, Scalar};

/// A symmetric 3 × 3 matrix, by the six entries of its upper triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Symmetric3<T> {
    /// Entry (x, x).
    pub xx: T,
    /// Entry (x, y).
    pub xy: T,
    /// Entry (x, z).
    pub xz: T,
    /// Entry (y, y).
    pub yy: T,
    /// Entry (y, z).
    pub yz: T,
    /// Entry (z, z).
    pub zz: T,
}

numbers! { struct Symmetric3 {
    xx: Finite("Jxx", "parameter of an inertia"),
    xy: Finite("Jxy", "parameter of an inertia"),
    yy: Finite("Jyy", "parameter of an inertia"),
    xz: Finite("Jxz", "parameter of an inertia"),
    yz: Finite("Jyz", "parameter of an inertia"),
    zz: Finite("Jzz", "parameter of an inertia"),
} }

impl<T: Scalar> Symmetric3<T> {
    /// Makes a symmetric matrix from the entries of its upper triangle, row by row.
    #[inline(always)]
    pub fn new(xx: T, xy: T, xz: T, yy: T, yz: T, zz: T) -> Self {
        Self {
            xx,
            xy,
            xz,
            yy,
            yz,
            zz,
        }
    }

    /// Zero matrix.
    #[inline]
    pub fn zero() -> Self {
        Self::scalar(T::zero())
    }

    /// Makes the matrix `s` 1.
    #[inline(always)]
    pub(crate) fn scalar(s: T) -> Self {
        Self::diagonal(&Vector3::new(s, s, s))
    }

    /// Makes a diagonal matrix from its diagonal.
    #[inline(always)]
    pub fn diagonal(d: &Vector3<T>) -> Self {
        Self::new(d.x, T::zero(), T::zero(), d.y, T::zero(), d.z)
    }

    /// Converts to a full matrix.
    #[inline(always)]
    pub fn to_matrix(&self) -> Matrix3<T> {
        Matrix3::new(
            self.xx, self.xy, self.xz, self.xy, self.yy, self.yz, self.xz, self.yz, self.zz,
        )
    }

    /// The k-th column.
    ///
    /// # Panics
    /// If `k ≥ 3`.
    #[inline(always)]
    pub(crate) fn column(&self, k: usize) -> Vector3<T> {
        match k {
            0 => Vector3::new(self.xx, self.xy, self.xz),
            1 => Vector3::new(self.xy, self.yy, self.yz),
            2 => Vector3::new(self.xz, self.yz, self.zz),
            _ => panic!("a 3 × 3 matrix has no column {k}"),
        }
    }

    /// `A v`, for a vector over any scalar that combines with the entries.
    #[inline(always)]
    pub(crate) fn times<S: Linear<T>>(&self, v: &Vector3<S>) -> Vector3<S> {
        Vector3::new(
            fused(v.x, self.xx, fused(v.y, self.xy, v.z * self.xz)),
            fused(v.x, self.xy, fused(v.y, self.yy, v.z * self.yz)),
            fused(v.x, self.xz, fused(v.y, self.yz, v.z * self.zz)),
        )
    }

    /// Computes R A Rᵀ: the matrix in the axes that `r` turns those of A to.
    #[inline(always)]
    pub(crate) fn rotated(&self, r: &Matrix3<T>) -> Self {
        // B = R A, then only the upper triangle of B Rᵀ.
        let [rx, ry, rz] = rows(r);
        let (x, y, z) = (
            self.times::<T>(&rx),
            self.times::<T>(&ry),
            self.times::<T>(&rz),
        );
        Self::new(
            dot(&x, &rx),
            dot(&x, &ry),
            dot(&x, &rz),
            dot(&y, &ry),
            dot(&y, &rz),
            dot(&z, &rz),
        )
    }

    /// The upper triangle of A + `[a]` B with a cross matrix and a matrix B of three rows, where the sum of several
    /// such steps is known to be symmetric.
    #[inline(always)]
    pub(crate) fn plus_cross(&self, a: &Vector3<T>, [x, y, z]: &[Vector3<T>; 3]) -> Self {
        Self::new(
            a.y.mul_add(z.x, (-a.z).mul_add(y.x, self.xx)),
            a.y.mul_add(z.y, (-a.z).mul_add(y.y, self.xy)),
            a.y.mul_add(z.z, (-a.z).mul_add(y.z, self.xz)),
            a.z.mul_add(x.y, (-a.x).mul_add(z.y, self.yy)),
            a.z.mul_add(x.z, (-a.x).mul_add(z.z, self.yz)),
            a.x.mul_add(y.z, (-a.y).mul_add(x.z, self.zz)),
        )
    }

    /// The upper triangle of A + (`[a]` B)ᵀ.
    #[inline(always)]
    pub(crate) fn plus_cross_transposed(
        &self,
        a: &Vector3<T>,
        [x, y, z]: &[Vector3<T>; 3],
    ) -> Self {
        Self::new(
            a.y.mul_add(z.x, (-a.z).mul_add(y.x, self.xx)),
            a.z.mul_add(x.x, (-a.x).mul_add(z.x, self.xy)),
            a.x.mul_add(y.x, (-a.y).mul_add(x.x, self.xz)),
            a.z.mul_add(x.y, (-a.x).mul_add(z.y, self.yy)),
            a.x.mul_add(y.y, (-a.y).mul_add(x.y, self.yz)),
            a.x.mul_add(y.z, (-a.y).mul_add(x.z, self.zz)),
        )
    }

    /// The upper triangle of A − a bᵀ, where the result, or the sum of several such steps, is known to be symmetric.
    #[inline(always)]
    pub(crate) fn minus_outer(&self, a: &Vector3<T>, b: &Vector3<T>) -> Self {
        Self::new(
            (-a.x).mul_add(b.x, self.xx),
            (-a.x).mul_add(b.y, self.xy),
            (-a.x).mul_add(b.z, self.xz),
            (-a.y).mul_add(b.y, self.yy),
            (-a.y).mul_add(b.z, self.yz),
            (-a.z).mul_add(b.z, self.zz),
        )
    }

    /// 2 (a · b) 1 − (a bᵀ + b aᵀ) = `−([a] [b] + [b] [a])` with cross matrices: how a moment of inertia changes when
    /// its origin is moved.
    #[inline(always)]
    pub(crate) fn parallel_axis(a: &Vector3<T>, b: &Vector3<T>) -> Self {
        let (x, y, z) = (a.x * b.x, a.y * b.y, a.z * b.z);
        Self::new(
            (y + z) * 2.0,
            -a.x.mul_add(b.y, a.y * b.x),
            -a.x.mul_add(b.z, a.z * b.x),
            (x + z) * 2.0,
            -a.y.mul_add(b.z, a.z * b.y),
            (x + y) * 2.0,
        )
    }

    /// Lifts the matrix to another scalar.
    #[inline(always)]
    pub(crate) fn lift<S: Over<T>>(&self) -> Symmetric3<S> {
        // Written out: the map of an array is not always inlined.
        Symmetric3 {
            xx: self.xx.into(),
            xy: self.xy.into(),
            xz: self.xz.into(),
            yy: self.yy.into(),
            yz: self.yz.into(),
            zz: self.zz.into(),
        }
    }
}

impl<P: Scalar> Cast<P> for Symmetric3<P> {
    type To<Q: Scalar> = Symmetric3<Q>;

    fn cast<Q: Over<P>>(&self) -> Symmetric3<Q> {
        self.lift()
    }
}

impl<T: Scalar> Add for Symmetric3<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        Self::new(
            self.xx + b.xx,
            self.xy + b.xy,
            self.xz + b.xz,
            self.yy + b.yy,
            self.yz + b.yz,
            self.zz + b.zz,
        )
    }
}

impl<T: Scalar> Sub for Symmetric3<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        Self::new(
            self.xx - b.xx,
            self.xy - b.xy,
            self.xz - b.xz,
            self.yy - b.yy,
            self.yz - b.yz,
            self.zz - b.zz,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::ROUNDING;
    use approx::assert_relative_eq;

    const A: Symmetric3<f64> = Symmetric3 {
        xx: 2.0,
        xy: 0.3,
        xz: -0.1,
        yy: 1.5,
        yz: 0.2,
        zz: 0.9,
    };

    #[test]
    fn rotated_equals_the_matrix_product() {
        let r = crate::spatial::Quaternion::exp(&Vector3::new(0.4, -1.0, 0.6)).to_matrix();
        assert_relative_eq!(
            A.rotated(&r).to_matrix(),
            r * A.to_matrix() * r.transpose(),
            epsilon = ROUNDING
        );
    }

    #[test]
    fn parallel_axis_equals_the_product_of_cross_matrices() {
        let (a, b) = (Vector3::new(0.4, -1.0, 0.6), Vector3::new(1.2, 0.3, -0.8));
        let (x, y) = (a.cross_matrix(), b.cross_matrix());
        assert_relative_eq!(
            Symmetric3::parallel_axis(&a, &b).to_matrix(),
            -(x * y + y * x),
            epsilon = ROUNDING
        );
    }

    #[test]
    fn times_and_columns_equal_the_full_matrix() {
        let v = Vector3::new(0.4, -1.0, 0.6);
        assert_relative_eq!(A.times(&v), A.to_matrix() * v, epsilon = ROUNDING);
        assert_eq!(
            Matrix3::from_columns(&[A.column(0), A.column(1), A.column(2)]),
            A.to_matrix()
        );
    }
}
