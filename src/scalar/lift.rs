//! Conversions from plain numbers to those of another scalar.

use super::Scalar;

/// Copies plain numbers into another scalar, without derivatives.
pub(crate) fn lift_into<T: Scalar>(x: &[f64], out: &mut [T]) {
    let both = out.iter_mut().zip(x);
    both.for_each(|(out, &x)| *out = T::constant(x));
}

/// x + δx, where only δx has derivatives.
pub(crate) fn add_into<T: Scalar>(x: &[f64], dx: &[T], out: &mut [T]) {
    let all = out.iter_mut().zip(x.iter().zip(dx));
    all.for_each(|(out, (&x, &dx))| *out = dx + x);
}
