//! Products of 3-vectors and 3 × 3 matrices, written out over [`Over`] so that a scalar meets model data without being
//! lifted first.

use nalgebra::{Matrix3, Vector3};

use crate::scalar::{Additive, Linear, Over, Scalar};

/// The vector of zeros, entry by entry: that of nalgebra goes through an iterator, which is not inlined everywhere, and over lanes goes through memory.
#[inline(always)]
pub(crate) fn zero<T: Additive>() -> Vector3<T> {
    Vector3::new(T::zero(), T::zero(), T::zero())
}

/// `x p + c` with data `p`, rounded once where the target can.
#[inline(always)]
pub(crate) fn fused<P: Scalar, T: Linear<P>>(x: T, p: P, c: T) -> T {
    x.times_plus(p, c)
}

/// `a × b`, the right factor may be model data.
#[inline(always)]
pub(crate) fn cross_data<P: Scalar, T: Linear<P>>(a: &Vector3<T>, b: &Vector3<P>) -> Vector3<T> {
    Vector3::new(
        fused(a.y, b.z, -(a.z * b.y)),
        fused(a.z, b.x, -(a.x * b.z)),
        fused(a.x, b.y, -(a.y * b.x)),
    )
}

/// `a × b`.
#[inline(always)]
pub(crate) fn cross<T: Scalar>(a: &Vector3<T>, b: &Vector3<T>) -> Vector3<T> {
    cross_data::<T, T>(a, b)
}

/// `c + a × b`, the right factor may be model data.
#[inline(always)]
pub(crate) fn add_cross_data<P: Scalar, T: Linear<P>>(
    c: &Vector3<T>,
    a: &Vector3<T>,
    b: &Vector3<P>,
) -> Vector3<T> {
    Vector3::new(
        fused(a.y, b.z, fused(-a.z, b.y, c.x)),
        fused(a.z, b.x, fused(-a.x, b.z, c.y)),
        fused(a.x, b.y, fused(-a.y, b.x, c.z)),
    )
}

/// `c − a × b`, the right factor may be model data.
#[inline(always)]
pub(crate) fn sub_cross_data<P: Scalar, T: Linear<P>>(
    c: &Vector3<T>,
    a: &Vector3<T>,
    b: &Vector3<P>,
) -> Vector3<T> {
    Vector3::new(
        fused(a.z, b.y, fused(-a.y, b.z, c.x)),
        fused(a.x, b.z, fused(-a.z, b.x, c.y)),
        fused(a.y, b.x, fused(-a.x, b.y, c.z)),
    )
}

/// `c + a × b`.
#[inline(always)]
pub(crate) fn add_cross<T: Scalar>(c: &Vector3<T>, a: &Vector3<T>, b: &Vector3<T>) -> Vector3<T> {
    add_cross_data::<T, T>(c, a, b)
}

/// `a · b`.
#[inline(always)]
pub(crate) fn dot<T: Scalar>(a: &Vector3<T>, b: &Vector3<T>) -> T {
    dot_data::<T, T>(a, b)
}

/// `a · b`, the right factor may be model data.
#[inline(always)]
pub(crate) fn dot_data<P: Scalar, T: Linear<P>>(a: &Vector3<T>, b: &Vector3<P>) -> T {
    fused(a.x, b.x, fused(a.y, b.y, a.z * b.z))
}

/// `a s`, the factor may be model data.
#[inline(always)]
pub(crate) fn scale_data<P: Scalar, T: Linear<P>>(a: &Vector3<T>, s: P) -> Vector3<T> {
    Vector3::new(a.x * s, a.y * s, a.z * s)
}

/// `a s`.
#[inline(always)]
pub(crate) fn scale<T: Scalar>(a: &Vector3<T>, s: T) -> Vector3<T> {
    scale_data::<T, T>(a, s)
}

/// `a s + c`, the factor may be model data.
#[inline(always)]
pub(crate) fn scale_add_data<P: Scalar, T: Linear<P>>(
    a: &Vector3<T>,
    s: P,
    c: &Vector3<T>,
) -> Vector3<T> {
    Vector3::new(fused(a.x, s, c.x), fused(a.y, s, c.y), fused(a.z, s, c.z))
}

/// `R v`, the rotation may be model data.
#[inline(always)]
pub(crate) fn rotate<P: Scalar, T: Linear<P>>(r: &Matrix3<P>, v: &Vector3<T>) -> Vector3<T> {
    Vector3::new(
        fused(v.x, r.m11, fused(v.y, r.m12, v.z * r.m13)),
        fused(v.x, r.m21, fused(v.y, r.m22, v.z * r.m23)),
        fused(v.x, r.m31, fused(v.y, r.m32, v.z * r.m33)),
    )
}

/// `Rᵀ v`, the rotation may be model data.
#[inline(always)]
pub(crate) fn rotate_back<P: Scalar, T: Linear<P>>(r: &Matrix3<P>, v: &Vector3<T>) -> Vector3<T> {
    Vector3::new(
        fused(v.x, r.m11, fused(v.y, r.m21, v.z * r.m31)),
        fused(v.x, r.m12, fused(v.y, r.m22, v.z * r.m32)),
        fused(v.x, r.m13, fused(v.y, r.m23, v.z * r.m33)),
    )
}

/// `Rᵀ p` for data `p`.
#[inline(always)]
pub(crate) fn rotate_back_data<P: Scalar, T: Linear<P>>(
    r: &Matrix3<T>,
    p: &Vector3<P>,
) -> Vector3<T> {
    Vector3::new(
        fused(r.m11, p.x, fused(r.m21, p.y, r.m31 * p.z)),
        fused(r.m12, p.x, fused(r.m22, p.y, r.m32 * p.z)),
        fused(r.m13, p.x, fused(r.m23, p.y, r.m33 * p.z)),
    )
}

/// `Rᵀ v + c`; what is about z comes last, for that is what a joint knows last of a motion.
#[inline(always)]
pub(crate) fn rotate_back_plus<T: Scalar>(
    r: &Matrix3<T>,
    v: &Vector3<T>,
    c: &Vector3<T>,
) -> Vector3<T> {
    Vector3::new(
        v.z.mul_add(r.m31, v.y.mul_add(r.m21, v.x.mul_add(r.m11, c.x))),
        v.z.mul_add(r.m32, v.y.mul_add(r.m22, v.x.mul_add(r.m12, c.y))),
        v.z.mul_add(r.m33, v.y.mul_add(r.m23, v.x.mul_add(r.m13, c.z))),
    )
}

/// `R p` for data `p`.
#[inline(always)]
pub(crate) fn rotate_data<P: Scalar, T: Linear<P>>(r: &Matrix3<T>, p: &Vector3<P>) -> Vector3<T> {
    Vector3::new(
        fused(r.m11, p.x, fused(r.m12, p.y, r.m13 * p.z)),
        fused(r.m21, p.x, fused(r.m22, p.y, r.m23 * p.z)),
        fused(r.m31, p.x, fused(r.m32, p.y, r.m33 * p.z)),
    )
}

/// The matrix of three columns; written out, it stays in registers where that of nalgebra goes through memory.
#[inline(always)]
pub(crate) fn from_columns<T: Scalar>(
    a: &Vector3<T>,
    b: &Vector3<T>,
    c: &Vector3<T>,
) -> Matrix3<T> {
    Matrix3::new(a.x, b.x, c.x, a.y, b.y, c.y, a.z, b.z, c.z)
}

/// The matrix of three rows.
#[inline(always)]
pub(crate) fn from_rows<T: Scalar>([a, b, c]: &[Vector3<T>; 3]) -> Matrix3<T> {
    Matrix3::new(a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z)
}

/// `A + B`.
#[inline(always)]
pub(crate) fn sum<T: Scalar>(a: &Matrix3<T>, b: &Matrix3<T>) -> Matrix3<T> {
    let ([a1, a2, a3], [b1, b2, b3]) = (rows(a), rows(b));
    from_rows(&[a1 + b1, a2 + b2, a3 + b3])
}

/// The rows of a matrix.
#[inline(always)]
pub(crate) fn rows<T: Scalar>(m: &Matrix3<T>) -> [Vector3<T>; 3] {
    [
        Vector3::new(m.m11, m.m12, m.m13),
        Vector3::new(m.m21, m.m22, m.m23),
        Vector3::new(m.m31, m.m32, m.m33),
    ]
}

/// The columns of a matrix.
#[inline(always)]
pub(crate) fn columns<T: Scalar>(m: &Matrix3<T>) -> [Vector3<T>; 3] {
    [
        Vector3::new(m.m11, m.m21, m.m31),
        Vector3::new(m.m12, m.m22, m.m32),
        Vector3::new(m.m13, m.m23, m.m33),
    ]
}

/// `A B` with data `B`.
#[inline(always)]
pub(crate) fn matrix_times_data<P: Scalar, T: Over<P>>(
    a: &Matrix3<T>,
    b: &Matrix3<P>,
) -> Matrix3<T> {
    let [x, y, z] = columns(b);
    from_columns(
        &rotate_data(a, &x),
        &rotate_data(a, &y),
        &rotate_data(a, &z),
    )
}

/// Lifts a vector to another scalar.
#[inline(always)]
pub(crate) fn lift_vector<P: Scalar, T: Over<P>>(v: &Vector3<P>) -> Vector3<T> {
    Vector3::new(v.x.into(), v.y.into(), v.z.into())
}

/// Lifts a matrix to another scalar.
#[inline(always)]
pub(crate) fn lift_matrix<P: Scalar, T: Over<P>>(m: &Matrix3<P>) -> Matrix3<T> {
    let [x, y, z] = rows(m);
    from_rows(&[lift_vector(&x), lift_vector(&y), lift_vector(&z)])
}
