//! Poses and motions of a body on dual numbers in its own directions.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{Matrix3, Vector3};

use crate::scalar::{Dual, Scalar};
use crate::spatial::linear::{cross, rotate};
use crate::spatial::{Motion, SPATIAL, Transform};

/// X exp(ξ) to first order in ξ, a motion of B in B, along the first six directions: δp = R ξᵥ, δR = R `[ξ_ω]×`.
pub(super) fn moved<T: Scalar, const N: usize>(X: &Transform<T>) -> Transform<Dual<T, N>> {
    let mut out = fixed(X);
    for k in 0..3 {
        let e = unit(k);
        let shift = rotate(&X.rotation, &e);
        for row in 0..3 {
            out.translation[row].eps[k] = shift[row];
        }
        let turn: Matrix3<T> = Matrix3::from_columns(&std::array::from_fn::<_, 3, _>(|column| {
            rotate(&X.rotation, &cross(&e, &unit(column)))
        }));
        let entries = out.rotation.iter_mut().zip(turn.iter());
        entries.for_each(|(x, &dx)| x.eps[3 + k] = dx);
    }
    out
}

/// V with a derivative of one in each of its coordinates, in the directions from `first` on.
pub(super) fn faster<T: Scalar, const N: usize>(V: &Motion<T>, first: usize) -> Motion<Dual<T, N>> {
    let mut out = fixed_motion(V);
    for k in 0..SPATIAL {
        out.coordinate_mut(k).eps[first + k] = T::one();
    }
    out
}

/// A pose without derivatives.
#[inline(always)]
pub(super) fn fixed<T: Scalar, const N: usize>(X: &Transform<T>) -> Transform<Dual<T, N>> {
    let rotation = X.rotation.map(Dual::constant_of);
    Transform::new(rotation, X.translation.map(Dual::constant_of))
}

/// A motion without derivatives.
#[inline(always)]
pub(super) fn fixed_motion<T: Scalar, const N: usize>(V: &Motion<T>) -> Motion<Dual<T, N>> {
    let angular = V.angular.map(Dual::constant_of);
    Motion::new(V.linear.map(Dual::constant_of), angular)
}

fn unit<T: Scalar>(k: usize) -> Vector3<T> {
    Vector3::from_fn(|i, _| if i == k { T::one() } else { T::zero() })
}
