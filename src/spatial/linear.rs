//! Products of 3-vectors and 3 × 3 matrices, written out over [`Over`] so that a scalar meets model data without being lifted first.

use nalgebra::{Matrix3, Vector3};

use crate::scalar::{Over, Scalar};

/// `a × b`, the right factor may be model data.
#[inline]
pub(crate) fn cross_data<P: Scalar, T: Over<P>>(a: &Vector3<T>, b: &Vector3<P>) -> Vector3<T> {
    Vector3::new(
        a.y * b.z - a.z * b.y,
        a.z * b.x - a.x * b.z,
        a.x * b.y - a.y * b.x,
    )
}

/// `a × b`.
#[inline]
pub(crate) fn cross<T: Scalar>(a: &Vector3<T>, b: &Vector3<T>) -> Vector3<T> {
    cross_data::<T, T>(a, b)
}

/// `a · b`.
#[inline]
pub(crate) fn dot<T: Scalar>(a: &Vector3<T>, b: &Vector3<T>) -> T {
    a.x * b.x + a.y * b.y + a.z * b.z
}

/// `a s`, the factor may be model data.
#[inline]
pub(crate) fn scale_data<P: Scalar, T: Over<P>>(a: &Vector3<T>, s: P) -> Vector3<T> {
    Vector3::new(a.x * s, a.y * s, a.z * s)
}

/// `a s`.
#[inline]
pub(crate) fn scale<T: Scalar>(a: &Vector3<T>, s: T) -> Vector3<T> {
    scale_data::<T, T>(a, s)
}

/// `R v`.
#[inline]
pub(crate) fn rotate<T: Scalar>(r: &Matrix3<T>, v: &Vector3<T>) -> Vector3<T> {
    rotate_data::<T, T>(r, v)
}

/// `Rᵀ v`.
#[inline]
pub(crate) fn rotate_back<T: Scalar>(r: &Matrix3<T>, v: &Vector3<T>) -> Vector3<T> {
    Vector3::new(
        r.m11 * v.x + r.m21 * v.y + r.m31 * v.z,
        r.m12 * v.x + r.m22 * v.y + r.m32 * v.z,
        r.m13 * v.x + r.m23 * v.y + r.m33 * v.z,
    )
}

/// `R p` for data `p`.
#[inline]
pub(crate) fn rotate_data<P: Scalar, T: Over<P>>(r: &Matrix3<T>, p: &Vector3<P>) -> Vector3<T> {
    Vector3::new(
        r.m11 * p.x + r.m12 * p.y + r.m13 * p.z,
        r.m21 * p.x + r.m22 * p.y + r.m23 * p.z,
        r.m31 * p.x + r.m32 * p.y + r.m33 * p.z,
    )
}

/// `A B` with data `B`.
#[inline]
pub(crate) fn matrix_times_data<P: Scalar, T: Over<P>>(
    a: &Matrix3<T>,
    b: &Matrix3<P>,
) -> Matrix3<T> {
    Matrix3::from_columns(&[
        column_product(a, b, 0),
        column_product(a, b, 1),
        column_product(a, b, 2),
    ])
}

#[inline]
fn column_product<P: Scalar, T: Over<P>>(a: &Matrix3<T>, b: &Matrix3<P>, k: usize) -> Vector3<T> {
    rotate_data::<P, T>(a, &Vector3::new(b[(0, k)], b[(1, k)], b[(2, k)]))
}

/// `A B`.
#[inline]
pub(crate) fn matrix_times<T: Scalar>(a: &Matrix3<T>, b: &Matrix3<T>) -> Matrix3<T> {
    matrix_times_data::<T, T>(a, b)
}

/// `A + [p]ₓ B`: every column of B is crossed with `p` from the left.
#[inline]
pub(crate) fn add_cross_matrix<T: Scalar>(
    a: &Matrix3<T>,
    p: &Vector3<T>,
    b: &Matrix3<T>,
) -> Matrix3<T> {
    let column = |k: usize| {
        let b = Vector3::new(b[(0, k)], b[(1, k)], b[(2, k)]);
        Vector3::new(a[(0, k)], a[(1, k)], a[(2, k)]) + cross(p, &b)
    };
    Matrix3::from_columns(&[column(0), column(1), column(2)])
}

/// The same vector over another scalar.
#[inline]
pub(crate) fn lift_vector<P: Scalar, T: Over<P>>(v: &Vector3<P>) -> Vector3<T> {
    Vector3::new(v.x.into(), v.y.into(), v.z.into())
}

/// The same matrix over another scalar.
#[inline]
pub(crate) fn lift_matrix<P: Scalar, T: Over<P>>(m: &Matrix3<P>) -> Matrix3<T> {
    m.map(<T as From<P>>::from)
}
