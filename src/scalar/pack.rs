//! Numbers of any scalar side by side, on which data act together.

use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

use num_traits::Zero;

use super::each::each;
use super::{Linear, Scalar, vectorized_over};

/// `N` numbers that the same data act on: columns of a matrix, say. Over `f64` the compiler makes vector instructions
/// of the loops, and it is aligned so that no vector lies across two cache lines that need not. Unlike
/// [`Lanes`](super::Lanes) no scalar: nothing multiplies two of them.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(32))]
pub(crate) struct Pack<T, const N: usize>(pub(crate) [T; N]);

impl<T: Scalar, const N: usize> Pack<T, N> {
    #[inline(always)]
    fn each(f: impl Fn(usize) -> T) -> Self {
        Self(each(f))
    }
}

impl<T: Scalar, const N: usize> Zero for Pack<T, N> {
    #[inline(always)]
    fn zero() -> Self {
        Self([T::zero(); N])
    }

    #[inline]
    fn is_zero(&self) -> bool {
        self.0.iter().all(T::is_zero)
    }
}

impl<T: Scalar, const N: usize> Add for Pack<T, N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self::each(|i| self.0[i] + other.0[i])
    }
}

impl<T: Scalar, const N: usize> AddAssign for Pack<T, N> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<T: Scalar, const N: usize> Sub for Pack<T, N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self::each(|i| self.0[i] - other.0[i])
    }
}

impl<T: Scalar, const N: usize> SubAssign for Pack<T, N> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl<T: Scalar, const N: usize> Neg for Pack<T, N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::each(|i| -self.0[i])
    }
}

impl<T: Scalar, const N: usize> Mul<T> for Pack<T, N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, p: T) -> Self {
        Self::each(|i| self.0[i] * p)
    }
}

impl<T: Scalar, const N: usize> Linear<T> for Pack<T, N> {
    #[inline(always)]
    fn times_plus(self, p: T, term: Self) -> Self {
        Self::each(|i| self.0[i].mul_add(p, term.0[i]))
    }

    #[inline(always)]
    fn vectorized<R>(work: impl FnOnce() -> R) -> R {
        vectorized_over::<T, R>(work)
    }
}
