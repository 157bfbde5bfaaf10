//! The scalar over which the physics is written.
//!
//! Every algorithm of the crate is generic over [`Scalar`]: `f64` gives values, the dual numbers of `num-dual` give exact derivatives, [`Lanes`]
//! many values at once, and other types (expression graphs) can be added without touching the physics. A scalar has *no ordering*: the
//! only door to a decision on a value is [`Scalar::select_lt`], which evaluates both sides, so that the control flow depends on the structure of the model alone.
//!
//! Data of a model have a type `P` of their own. [`Over<P>`] says that a scalar can be combined with it: `f64` data under dual states, or dual
//! data for derivatives in masses and lengths.

mod lanes;
mod lift;
mod sin_cos;
mod vectorized;

pub(crate) use vectorized::{GROUP, plus_scaled, vectorized};

pub use lanes::Lanes;
pub(crate) use lift::{add_into, lift_into};
pub(crate) use sin_cos::sin_cos_each;

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

use num_dual::DualNum;
use num_traits::{One, Zero};

/// A real number, possibly with derivatives or several lanes attached.
///
/// Constants stand on the right: `x * 0.5`. At most two types meet in an expression: the scalar itself and `f64`.
///
/// # Examples
/// ```
/// use dualbody::Scalar;
///
/// fn kinetic<T: Scalar>(m: T, v: T) -> T {
///     m * v * v * 0.5
/// }
/// assert_eq!(kinetic(2.0, 3.0), 9.0);
/// ```
pub trait Scalar:
    Copy
    + Debug
    + PartialEq
    + Send
    + Sync
    + 'static
    + Zero
    + One
    + From<f64>
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
    + DivAssign
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
{
    /// The square root. Its derivative is not finite at 0: guard the argument *before* the call.
    fn sqrt(self) -> Self;

    /// Sine and cosine of an angle in radians.
    fn sin_cos(self) -> (Self, Self);

    /// Sines and cosines of many angles, which some types compute faster together.
    ///
    /// * `out` – output, as long as `x`
    #[inline(always)]
    fn sin_cos_each(x: &[Self], out: &mut [(Self, Self)]) {
        sin_cos_one_by_one(x, out);
    }

    /// The exponential eˣ.
    fn exp(self) -> Self;

    /// The natural logarithm; its argument must be positive.
    fn ln(self) -> Self;

    /// The angle of the point (`x`, `self`) in (−π, π], in radians. Differentiable everywhere but at the origin.
    fn atan2(self, x: Self) -> Self;

    /// `self * factor + term`, rounded once where the target has such an instruction.
    #[inline]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        self * factor + term
    }

    /// `self * factor + term` for a factor without derivatives, the same in every lane.
    #[inline]
    fn mul_add_real(self, factor: f64, term: Self) -> Self {
        self * factor + term
    }

    /// `x * self + term`, where this number is data under the scalar of `x`; see [`Over`].
    #[inline]
    fn scale_add<T: Over<Self>>(self, x: T, term: T) -> T {
        x * self + term
    }

    /// Runs `work`; types for which it pays do so with the widest vector instructions that the CPU turns out to have.
    #[inline(always)]
    fn vectorized<R>(work: impl FnOnce() -> R) -> R {
        work()
    }

    /// `if self < other { a } else { b }`, lane by lane; the derivative is that of the chosen side.
    fn select_lt(self, other: Self, a: Self, b: Self) -> Self;

    /// How many values stand side by side: 1 but for [`Lanes`].
    const LANES: usize = 1;

    /// The highest derivative that the type carries; 0 for values alone.
    const ORDER: usize;

    /// The value in a lane, without derivatives: where an iteration must decide on values, it runs on these, and the implicit
    /// function theorem gives the derivatives.
    ///
    /// # Panics
    /// If there is no such lane.
    fn value(&self, lane: usize) -> f64;

    /// A number without derivatives, from the value in each lane.
    fn from_values(value: impl FnMut(usize) -> f64) -> Self;

    /// A number without derivatives: the same value in every lane.
    fn constant(value: f64) -> Self {
        <Self as From<f64>>::from(value)
    }

    /// The absolute value; at 0 the derivative is that of `+self`.
    fn abs(self) -> Self {
        self.select_lt(Self::zero(), -self, self)
    }

    /// The smaller of two numbers (`other` where they are equal).
    fn min(self, other: Self) -> Self {
        self.select_lt(other, self, other)
    }

    /// The larger of two numbers (`other` where they are equal).
    fn max(self, other: Self) -> Self {
        other.select_lt(self, self, other)
    }

    /// The number limited to `[low, high]`; outside, the derivative is 0.
    fn clamp(self, low: f64, high: f64) -> Self {
        self.max(Self::constant(low)).min(Self::constant(high))
    }
}

/// Whether a type is one value without derivatives, so that its value is all of it.
pub(crate) const fn is_plain<T: Scalar>() -> bool {
    T::LANES == 1 && T::ORDER == 0
}

#[inline(always)]
fn sin_cos_one_by_one<T: Scalar>(x: &[T], out: &mut [(T, T)]) {
    for (out, x) in out.iter_mut().zip(x) {
        *out = x.sin_cos();
    }
}

impl<D: DualNum<Primitive = f64> + Copy + Send + Sync> Scalar for D {
    const ORDER: usize = D::NDERIV;

    #[inline]
    fn value(&self, lane: usize) -> f64 {
        assert_eq!(lane, 0, "there is one lane");
        self.re()
    }

    #[inline]
    fn from_values(mut value: impl FnMut(usize) -> f64) -> Self {
        Self::constant(value(0))
    }

    #[inline]
    fn sqrt(self) -> Self {
        DualNum::sqrt(&self)
    }

    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        if D::NDERIV > 0 {
            return DualNum::sin_cos(&self);
        }
        let ([sin], [cos]) = sin_cos::sin_cos([self.re()]);
        (Self::constant(sin), Self::constant(cos))
    }

    #[inline]
    fn sin_cos_each(x: &[Self], out: &mut [(Self, Self)]) {
        if D::NDERIV > 0 {
            return sin_cos_one_by_one(x, out);
        }
        let apply = |_: &Self, sin, cos| (Self::constant(sin), Self::constant(cos));
        sin_cos_each(x, out, Self::re, apply);
    }

    #[inline]
    fn exp(self) -> Self {
        DualNum::exp(&self)
    }

    #[inline]
    fn ln(self) -> Self {
        DualNum::ln(&self)
    }

    #[inline]
    fn atan2(self, x: Self) -> Self {
        let value = self.re().atan2(x.re());
        if D::NDERIV == 0 {
            return Self::constant(value);
        }
        // num-dual differentiates atan(y / x), which is not finite at x = 0. The quotient of the smaller by the larger always is; only its
        // derivatives are used, the value comes from the library function.
        let angle = if self.re().abs() <= x.re().abs() {
            (self / x).atan()
        } else {
            -(x / self).atan()
        };
        angle + (value - angle.re())
    }

    // Of the types here, only plain numbers have an instruction; on a target without it the call would go to a slow library function.
    #[inline]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        if D::NDERIV == 0 && cfg!(target_feature = "fma") {
            DualNum::mul_add(&self, factor, term)
        } else {
            self * factor + term
        }
    }

    #[inline]
    fn mul_add_real(self, factor: f64, term: Self) -> Self {
        if D::NDERIV == 0 {
            Scalar::mul_add(self, Self::constant(factor), term)
        } else {
            self * factor + term
        }
    }

    #[inline]
    fn scale_add<T: Over<Self>>(self, x: T, term: T) -> T {
        if D::NDERIV == 0 {
            x.mul_add_real(self.re(), term)
        } else {
            x * self + term
        }
    }

    #[inline]
    fn select_lt(self, other: Self, a: Self, b: Self) -> Self {
        if self.re() < other.re() { a } else { b }
    }
}

/// A scalar that can be combined with data of type `P`: `T::from(p)`, `t + p`, `t - p`, `t * p`.
///
/// Implemented for every type that has these operations; `T: Over<f64>` and `T: Over<T>` hold for every scalar of `num-dual`.
pub trait Over<P>:
    Scalar + From<P> + Add<P, Output = Self> + Sub<P, Output = Self> + Mul<P, Output = Self>
{
}

impl<P, T: Scalar + From<P> + Add<P, Output = T> + Sub<P, Output = T> + Mul<P, Output = T>> Over<P>
    for T
{
}
