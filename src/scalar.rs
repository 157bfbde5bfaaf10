//! Scalars of the physics.
//!
//! All algorithms of the crate are generic over [`Scalar`]: `f64` gives values, dual numbers give exact derivatives, [`Lanes`] several values at
//! once, [`SingleLanes`] more values in single precision, [`Traced`] an expression graph for code generation. [Custom
//! types](Scalar#writing-a-scalar-of-your-own) need no change of the physics.
//!
//! | question | scalar | cost of an operation |
//! |---|---|---|
//! | values? | `f64` | 1 |
//! | several states or robots at once? | [`Lanes`] of [`BATCH_WIDTH`], [`SingleLanes`] | one vector instruction |
//! | N derivatives, exact? | [`Dual`], the types of `num-dual` | 1 + N, or a vector instruction for four directions |
//! | higher derivatives? | [`Dual`] over [`Dual`], `HyperDual64` | product of both |
//! | a graph, for C, CUDA, reverse mode? | [`Traced`] | a look-up while recording |
//!
//! A scalar has *no ordering*. The only decision on values is [`Scalar::select_lt`], which evaluates both sides, so control flow depends only on the
//! structure of the model. The documentation of [`Scalar`] lists the exceptions.
//!
//! Model data have their own type `P`. [`Over<P>`] means that a scalar can be combined with it: `f64` data with dual states, or dual data for
//! derivatives in masses and lengths.

mod cast;
mod compiled;
mod dual;
mod each;
mod float;
mod lanes;
mod lift;
mod num_dual;
mod over;
mod pack;
mod sin_cos;
mod single_sin_cos;
pub mod traced;
mod vectorized;
mod widths;

pub(crate) use compiled::{Opaque, compiled_over_f64, same};
pub(crate) use each::{MapEach, each, from_each, pairs};
pub(crate) use vectorized::{has_lanes, plus_scaled, vectorized, vectorized_over};
pub use widths::{BATCH_WIDTH, CHUNK};
pub(crate) use widths::{BLOCK, CACHE_LINE, ELIMINATED, GROUP, LEVEL, TILE};

pub use cast::Cast;
pub use dual::Dual;
pub use lanes::{Lanes, SingleLanes};
pub(crate) use lift::{add_into, lift_into};
pub use over::{Additive, Differentiable, DualNumber, Linear, Over};
pub(crate) use pack::Pack;
pub use traced::{Graph, Traced};

use std::any::TypeId;
use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// Identity elements of a [`Scalar`], from `num-traits`.
pub use num_traits::{One, Zero};

/// A real number, possibly with derivatives or several lanes.
///
/// Implemented for `f64`, [`Lanes`], [`SingleLanes`], [`Dual`], [`Traced`] and the types of num-dual but `num_dual::Real<f64>`, in place of which `f64` is used.
///
/// Constants are on the right: `x * 0.5`. An expression contains at most two types: the scalar itself and `f64`.
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
///
/// # Writing a scalar of your own
/// Intervals, single precision, recording numbers: any `Copy` type with the operators of this trait works in all algorithms. Implement the operators,
/// [`Zero`], [`One`] and `From<f64>`, the functions without a default ([`sqrt`](Self::sqrt), [`sin_cos`](Self::sin_cos), [`exp`](Self::exp),
/// [`ln`](Self::ln), [`atan2`](Self::atan2), [`select_lt`](Self::select_lt)), and [`value`](Self::value). [`Over`] is implemented automatically;
/// derivatives along the tree also need [`differentiable!`](crate::differentiable). All other functions have defaults; override those that a type can
/// do better.
///
/// [`ORDER`](Self::ORDER) is 0 by default. Set it only for numbers that consist of a value and infinitesimals, such as dual numbers: algorithms then
/// compute values on `f64`, and derivatives by the implicit function theorem. A number of order 0 other than `f64` is never replaced by its value,
/// and no branch depends on it, with these exceptions, which read values:
///
/// | algorithm | use of values | other content of a number |
/// |---|---|---|
/// | contact points, joint limits in implicit steps | selection of those that take part in a step | unchanged |
/// | [`HeightField`](crate::contact::HeightField) | the cell of a point | unchanged |
/// | rigid and regularised rigid contact, constraints, soft contact in implicit steps ([`ConeSolver`](crate::cone::ConeSolver)) | forces | one Newton step from there, on the active pieces of the laws |
/// | [`TerrainFunction`](crate::contact::TerrainFunction) | height and slope | the tangent there |
/// | friction, shapes of impedance | validity checks | not checked |
///
/// So intervals through a solver are correct to first order in their width. A [`Traced`] number has no value and uses alternatives, such as a fixed
/// number of solver steps for regularised contact, or the operations of a user function; [its module](traced) lists the supported algorithms.
///
/// ```
/// use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};
/// use dualbody::dynamics::{forward_dynamics, inverse_dynamics_derivatives};
/// use dualbody::{Scalar, model::samples, scalar::{One, Zero}};
///
/// #[derive(Clone, Copy, Debug, PartialEq)]
/// struct Single(f32);
///
/// macro_rules! operators {
///     ($($operator:ident $method:ident $assign:ident $assign_method:ident;)*) => {$(
///         impl $operator for Single {
///             type Output = Self;
///             fn $method(self, other: Self) -> Self { Self(self.0.$method(other.0)) }
///         }
///         impl $operator<f64> for Single {
///             type Output = Self;
///             fn $method(self, other: f64) -> Self { self.$method(Self::from(other)) }
///         }
///         impl $assign for Single {
///             fn $assign_method(&mut self, other: Self) { *self = self.$method(other) }
///         }
///     )*};
/// }
/// operators! {
///     Add add AddAssign add_assign;
///     Sub sub SubAssign sub_assign;
///     Mul mul MulAssign mul_assign;
///     Div div DivAssign div_assign;
/// }
/// impl Neg for Single {
///     type Output = Self;
///     fn neg(self) -> Self { Self(-self.0) }
/// }
/// impl From<f64> for Single {
///     fn from(x: f64) -> Self { Self(x as f32) }
/// }
/// impl Zero for Single {
///     fn zero() -> Self { Self(0.0) }
///     fn is_zero(&self) -> bool { self.0 == 0.0 }
/// }
/// impl One for Single {
///     fn one() -> Self { Self(1.0) }
/// }
/// impl Scalar for Single {
///     fn sqrt(self) -> Self { Self(self.0.sqrt()) }
///     fn sin_cos(self) -> (Self, Self) { (Self(self.0.sin()), Self(self.0.cos())) }
///     fn exp(self) -> Self { Self(self.0.exp()) }
///     fn ln(self) -> Self { Self(self.0.ln()) }
///     fn atan2(self, x: Self) -> Self { Self(self.0.atan2(x.0)) }
///     fn select_lt(self, other: Self, a: Self, b: Self) -> Self { if self.0 < other.0 { a } else { b } }
///     fn value(&self, _lane: usize) -> f64 { self.0.into() }
/// }
/// dualbody::differentiable! { [] Single; }
///
/// // A rod of 1 m let go at the horizontal: −3 g / 2, to the digits of single precision
/// let model = samples::pendulum();
/// let a = forward_dynamics(&model, &[Single(std::f32::consts::FRAC_PI_2)], &[Single(0.0)], &[Single(0.0)]);
/// assert!((a[0].0 + 14.715).abs() < 1e-5);
/// // and how the torque that holds it changes with the angle there: (m g l / 2) cos q = 0
/// let d = inverse_dynamics_derivatives(&model, &[Single(std::f32::consts::FRAC_PI_2)], &[Single(0.0)], &[Single(0.0)]);
/// assert!(d.dq[0].0.abs() < 1e-5 && (d.da[0].0 - 1.0 / 3.0).abs() < 1e-6);
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

    /// The tangent; its poles are where the cosine is zero.
    #[inline]
    fn tan(self) -> Self {
        let (sin, cos) = self.sin_cos();
        sin / cos
    }

    /// The angle in ±π/2 that has this sine, in radians; NaN outside ±1, where its derivative is not finite.
    #[inline]
    fn asin(self) -> Self {
        self.atan2(cosine_of_sine(self))
    }

    /// The angle in 0..π that has this cosine, in radians; NaN outside ±1, where its derivative is not finite.
    #[inline]
    fn acos(self) -> Self {
        cosine_of_sine(self).atan2(self)
    }

    /// The hyperbolic tangent, for arguments of any size.
    #[inline]
    fn tanh(self) -> Self {
        tanh_by_exp(self)
    }

    /// The power to a whole number by repeated squaring; x⁰ is 1 for any x.
    #[inline]
    fn powi(self, exponent: i32) -> Self {
        let power = power(self, exponent.unsigned_abs());
        if exponent < 0 {
            Self::one() / power
        } else {
            power
        }
    }

    /// Number of values side by side: 1 except for [`Lanes`] and [`SingleLanes`]. A type of several lanes contains only its values.
    const LANES: usize = 1;

    /// The highest derivative that the type carries, 0 for none. Not 0, it says that a number is
    /// [`value(0)`](Self::value) and an infinitesimal part of which every product of more than `ORDER` factors is zero,
    /// and nothing else.
    const ORDER: usize = 0;

    /// The value in a lane, without derivatives: where an iteration must decide on values, it runs on these, and the
    /// implicit function theorem gives the derivatives.
    ///
    /// # Panics
    /// If there is no such lane, or the number [has no value](Self::has_value).
    #[track_caller]
    fn value(&self, lane: usize) -> f64;

    /// Whether the number has a [`value`](Self::value): not one that is an expression of inputs yet to come, as
    /// [`Traced`] is. Checks of domains skip such numbers.
    #[inline(always)]
    fn has_value(&self) -> bool {
        true
    }

    /// Whether a number is at most a limit in all lanes, for algorithms with another branch beyond it. A recorded graph assumes that it holds, stores
    /// the condition, and reports a violation at evaluation.
    ///
    /// * `condition` – the assumption, as text
    #[track_caller]
    #[inline(always)]
    fn is_at_most(&self, limit: f64, condition: &str) -> bool {
        let _ = condition;
        // NaN is within all limits.
        !(0..Self::LANES).any(|lane| self.value(lane) > limit)
    }

    /// Whether a number is nothing but its values, or these and infinitesimals for which [`ORDER`](Self::ORDER) stands:
    /// only then dual numbers over it can be taken apart.
    #[doc(hidden)]
    const IS_VALUES: bool = false;

    /// Whether a solver can iterate on values of the type; otherwise that code is not compiled.
    #[doc(hidden)]
    const HAS_VALUES: bool = true;

    /// Whether the type is `f64`, over which the library contains the code of its generic functions.
    #[doc(hidden)]
    const IS_F64: bool = false;

    /// A number without derivatives, from the value in each lane. To be written by types of several lanes.
    #[inline]
    fn from_values(mut value: impl FnMut(usize) -> f64) -> Self {
        Self::constant(value(0))
    }

    /// The number without its derivatives, if it contains only values besides; a recorded one is unchanged.
    #[doc(hidden)]
    #[inline(always)]
    fn detached(self) -> Self {
        Self::from_values(|lane| self.value(lane))
    }

    /// A number without derivatives: the same value in every lane.
    #[inline]
    fn constant(value: f64) -> Self {
        <Self as From<f64>>::from(value)
    }

    /// The absolute value; at 0 the derivative is that of `+self`.
    #[inline]
    fn abs(self) -> Self {
        self.select_lt(Self::zero(), -self, self)
    }

    /// The smaller of two numbers (`other` where they are equal).
    #[inline]
    fn min(self, other: Self) -> Self {
        self.select_lt(other, self, other)
    }

    /// The larger of two numbers (`other` where they are equal).
    #[inline]
    fn max(self, other: Self) -> Self {
        other.select_lt(self, self, other)
    }

    /// The number limited to `[low, high]`; outside, the derivative is 0.
    #[inline]
    fn clamp(self, low: f64, high: f64) -> Self {
        self.max(Self::constant(low)).min(Self::constant(high))
    }
}

/// Whether a type is `f64` itself, so that its value is all of it. No constant of the trait says so, for a type could
/// not tell by its order alone: an interval has no derivatives, and is not its midpoint.
#[inline(always)]
pub(crate) fn is_f64<T: Scalar>() -> bool {
    TypeId::of::<T>() == TypeId::of::<f64>()
}

/// Whether a type may be `f64`, told when compiled: what cannot be is not compiled where only `f64` comes.
#[inline(always)]
pub(crate) const fn may_be_f64<T: Scalar>() -> bool {
    T::LANES == 1 && T::ORDER == 0
}

/// Whether a number may be more, or less, than its values: derivatives, bounds, a graph, fewer digits.
#[inline(always)]
pub(crate) fn is_more_than_values<T: Scalar>() -> bool {
    T::ORDER > 0 || (T::LANES == 1 && !is_f64::<T>())
}

/// Whether numbers are a value and infinitesimals of which products of more than so many vanish, for which
/// [`Scalar::ORDER`] stands.
#[inline(always)]
pub(crate) const fn is_differential<T: Scalar>() -> bool {
    T::LANES == 1 && T::ORDER > 0
}

/// `true` if a number is zero with all that it holds: what may be left out of sums. The types of num-dual compare their values alone, so that no
/// number with derivatives counts.
#[inline(always)]
pub(crate) fn is_nothing<T: Scalar>(x: &T) -> bool {
    T::ORDER == 0 && x.is_zero()
}

/// √(1 − x²), exact also near ±1.
#[inline]
fn cosine_of_sine<T: Scalar>(x: T) -> T {
    ((T::one() - x) * (x + 1.0)).sqrt()
}

/// tanh |x| = (1 − e⁻²ˣ) / (1 + e⁻²ˣ), which does not overflow.
#[inline]
fn tanh_by_exp<T: Scalar>(x: T) -> T {
    let e = (x.abs() * -2.0).exp();
    let size = (T::one() - e) / (e + 1.0);
    x.select_lt(T::zero(), -size, size)
}

#[inline]
fn power<T: Scalar>(mut square: T, mut exponent: u32) -> T {
    let mut power = T::one();
    while exponent > 0 {
        if exponent & 1 == 1 {
            power *= square;
        }
        exponent >>= 1;
        if exponent > 0 {
            square *= square;
        }
    }
    power
}

#[inline(always)]
fn sin_cos_one_by_one<T: Scalar>(x: &[T], out: &mut [(T, T)]) {
    for (out, x) in out.iter_mut().zip(x) {
        *out = x.sin_cos();
    }
}
