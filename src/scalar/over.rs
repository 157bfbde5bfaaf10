//! Scalars over data of another type, and their duals.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

use num_traits::Zero;

use super::{Dual, Lanes, Scalar, SingleLanes};

/// A scalar that can be combined with data of type `P`: `T::from(p)`, `t + p`, `t - p`, `t * p`.
///
/// Implemented for all types with these operations; `T: Over<f64>` and `T: Over<T>` hold for all scalars.
pub trait Over<P>:
    Scalar + From<P> + Add<P, Output = Self> + Sub<P, Output = Self> + Mul<P, Output = Self>
{
}

impl<P, T: Scalar + From<P> + Add<P, Output = T> + Sub<P, Output = T> + Mul<P, Output = T>> Over<P>
    for T
{
}

/// Additive types: scalars, or packs of several scalars.
pub trait Additive:
    Copy
    + Debug
    + PartialEq
    + 'static
    + Zero
    + Sub<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
{
}

impl<
    T: Copy
        + Debug
        + PartialEq
        + 'static
        + Zero
        + Sub<Output = T>
        + Neg<Output = T>
        + AddAssign
        + SubAssign,
> Additive for T
{
}

/// Types on which data of type `P` act linearly: scalars [`Over`] them, or packs of several.
pub trait Linear<P>: Additive + Mul<P, Output = Self> {
    /// `self · p + term`, rounded once where the target has such an instruction.
    fn times_plus(self, p: P, term: Self) -> Self;

    /// Runs `work`, for many numbers at once with the widest vector instructions that the CPU turns out to have.
    fn vectorized<R>(work: impl FnOnce() -> R) -> R;
}

impl<P: Scalar, T: Over<P>> Linear<P> for T {
    #[inline(always)]
    fn times_plus(self, p: P, term: Self) -> Self {
        p.scale_add(self, term)
    }

    #[inline(always)]
    fn vectorized<R>(work: impl FnOnce() -> R) -> R {
        <Self as Scalar>::vectorized(work)
    }
}

/// A scalar whose dual numbers are scalars over it: required by derivatives along the tree.
///
/// Implemented for `f64`, [`Lanes`], [`Dual`] and the types of num-dual, and for types of your own by
/// [`differentiable!`](crate::differentiable).
pub trait Differentiable: Scalar {
    /// The dual number over it with `N` directions.
    type Dual<const N: usize>: Over<Self> + DualNumber<Self, N>;
}

/// A value with its derivatives in `N` directions: [`Dual`], for code that is generic over the inner scalar.
pub trait DualNumber<T: Scalar, const N: usize>: Scalar {
    /// A value with its derivatives.
    fn new(re: T, eps: [T; N]) -> Self;

    /// The value.
    fn re(&self) -> T;

    /// The derivatives, one for each direction.
    fn eps(&self) -> &[T; N];

    /// The variable of a direction: derivative one in it, zero in the others.
    ///
    /// # Panics
    /// If there is no such direction.
    #[inline(always)]
    fn variable(re: T, direction: usize) -> Self {
        let mut eps = [T::zero(); N];
        eps[direction] = T::one();
        Self::new(re, eps)
    }
}

/// Lets derivatives along the tree run on scalars of your own: makes them data under their own duals.
///
/// `differentiable! { [generics] Type; … }`, each of which is a [`Scalar`].
///
/// The type of [`Scalar`'s chapter](Scalar#writing-a-scalar-of-your-own) becomes so by
/// `differentiable! { [] Single; }`, one over another scalar by `differentiable! { [T: Scalar] Pair<T>; }`.
#[macro_export]
macro_rules! differentiable {
    ($([$($generics:tt)*] $type:ty;)*) => {$(
        impl<$($generics)*> $crate::scalar::Differentiable for $type {
            type Dual<const DUAL: usize> = $crate::scalar::Dual<Self, DUAL>;
        }

        $crate::data_under_duals! {
            [T: $crate::scalar::Over<$type>, const DUAL: usize, $($generics)*] $type, T, DUAL;
        }
    )*};
}

/// The operators between a dual number and data that its inner scalar can be combined with; a part of
/// [`differentiable!`](crate::differentiable).
#[doc(hidden)]
#[macro_export]
macro_rules! data_under_duals {
    ($([$($generics:tt)*] $data:ty, $inner:ty, $n:ident;)*) => {$(
        impl<$($generics)*> From<$data> for $crate::scalar::Dual<$inner, $n> {
            #[inline(always)]
            fn from(p: $data) -> Self {
                Self::constant_of(<$inner as From<$data>>::from(p))
            }
        }

        impl<$($generics)*> std::ops::Add<$data> for $crate::scalar::Dual<$inner, $n> {
            type Output = Self;
            #[inline(always)]
            fn add(self, p: $data) -> Self {
                Self::new(self.re + p, self.eps)
            }
        }

        impl<$($generics)*> std::ops::Sub<$data> for $crate::scalar::Dual<$inner, $n> {
            type Output = Self;
            #[inline(always)]
            fn sub(self, p: $data) -> Self {
                Self::new(self.re - p, self.eps)
            }
        }

        impl<$($generics)*> std::ops::Mul<$data> for $crate::scalar::Dual<$inner, $n> {
            type Output = Self;
            #[inline(always)]
            fn mul(self, p: $data) -> Self {
                self.each(|x| x * p)
            }
        }
    )*};
}

crate::differentiable! {
    [const L: usize] Lanes<L>;
    [const L: usize] SingleLanes<L>;
}

// Data under their own duals only: under all that can be combined with them they would be so under themselves, too.
crate::data_under_duals! {
    [T: Scalar, const K: usize, const N: usize] Dual<T, K>, Dual<T, K>, N;
}

impl Differentiable for f64 {
    type Dual<const N: usize> = Dual<Self, N>;
}

impl<T: Scalar, const K: usize> Differentiable for Dual<T, K> {
    type Dual<const N: usize> = Dual<Self, N>;
}
