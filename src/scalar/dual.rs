//! A dual number with a fixed number of directions, in plain arrays.
//!
//! The vector types of `num-dual` keep their derivative part optional, which costs a branch in each operation and prevents vector instructions. This
//! type always has its `N` derivatives; the drivers of this crate use it. Both are scalars and give the same results. Over another scalar it
//! differentiates the results of that one: several lanes, derivatives, a recorded graph.

use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

use num_traits::{One, Zero};

use super::each::each;
use super::widths::ANGLES;
use super::{DualNumber, Over, Scalar};

/// x + Σᵢ εᵢ dᵢ with εᵢ εⱼ = 0: a value with its derivatives in `N` directions, over an inner scalar `T`.
///
/// # Examples
/// ```
/// use dualbody::{Scalar, autodiff::Dual};
///
/// // d/dx x² sin x = 2 x sin x + x² cos x
/// let x = Dual::<f64, 1>::variable(0.5, 0);
/// let y = x * x * x.sin_cos().0;
/// assert!((y.eps[0] - (0.5_f64.sin() + 0.25 * 0.5_f64.cos())).abs() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual<T, const N: usize> {
    /// The value.
    pub re: T,
    /// The derivatives, one for each direction.
    pub eps: [T; N],
}

/// Size, in bytes, from which a dual number over dual numbers performs its operations by function calls: sixteen directions of a body are above it, four of a
/// coordinate below. Inlined, each product is about a hundred instructions, and these numbers were 2.5 MB of machine code; with calls they are 0.45. Second
/// derivatives of the humanoid in contact take 4 % (regularised) to 11 % (soft) longer, those without contact as long as before; with calls for four directions
/// too, up to 27 %. Calls in first derivatives would make the library smaller by a fortieth, and A and B of a robot that stands take 9 % more instructions.
const LARGE: usize = 128;

impl<T: Scalar, const N: usize> Dual<T, N> {
    /// Whether operations are calls. Lanes are not, since a call would leave the code for wide vectors.
    const IS_LARGE: bool = T::LANES == 1 && T::ORDER > 0 && size_of::<Self>() >= LARGE;

    /// f of two arguments, by a call where the number is large.
    #[inline(always)]
    fn apply<A, R>(self, other: A, f: impl Fn(Self, A) -> R) -> R {
        if const { Self::IS_LARGE } {
            called(self, other, f)
        } else {
            f(self, other)
        }
    }

    /// A value with its derivatives.
    #[inline(always)]
    pub fn new(re: T, eps: [T; N]) -> Self {
        Self { re, eps }
    }

    /// The variable of a direction: derivative one in it, zero in the others.
    ///
    /// # Panics
    /// If there is no such direction.
    #[inline(always)]
    pub fn variable(re: T, direction: usize) -> Self {
        DualNumber::variable(re, direction)
    }

    /// A value of the inner scalar, without derivatives.
    #[inline(always)]
    pub fn constant_of(re: T) -> Self {
        Self::new(re, each(|_| T::zero()))
    }

    /// Applies a linear f to value and derivatives.
    #[doc(hidden)]
    #[inline(always)]
    pub fn each(self, f: impl Fn(T) -> T) -> Self {
        let eps = each(|i| f(self.eps[i]));
        Self::new(f(self.re), eps)
    }

    /// Applies a linear f to the values and to the derivatives of two numbers.
    #[doc(hidden)]
    #[inline(always)]
    pub fn zip(self, other: Self, f: impl Fn(T, T) -> T) -> Self {
        let eps = each(|i| f(self.eps[i], other.eps[i]));
        Self::new(f(self.re, other.re), eps)
    }

    /// f(x) from f's value and derivative at x.
    #[inline(always)]
    fn chain(self, value: T, derivative: T) -> Self {
        self.apply((value, derivative), |x, (value, derivative)| {
            Self::new(value, each(|i| x.eps[i] * derivative))
        })
    }

    /// `a` d(self) + `b` d(other) with the value `re`.
    #[inline(always)]
    fn combine(self, a: T, other: Self, b: T, re: T) -> Self {
        self.apply((a, other, b, re), |x, (a, other, b, re)| {
            Self::new(re, each(|i| x.eps[i].mul_add(a, other.eps[i] * b)))
        })
    }
}

/// f of two arguments, in a function of its own.
#[inline(never)]
fn called<A, B, R>(a: A, b: B, f: impl Fn(A, B) -> R) -> R {
    f(a, b)
}

/// The cosine, not negative, of an angle with this sine, or the other way round.
#[inline]
fn cosine<T: Scalar>(sine: T) -> T {
    ((-sine + 1.0) * (sine + 1.0)).sqrt()
}

impl<T: Scalar, const N: usize> DualNumber<T, N> for Dual<T, N> {
    #[inline(always)]
    fn new(re: T, eps: [T; N]) -> Self {
        Self { re, eps }
    }

    #[inline(always)]
    fn re(&self) -> T {
        self.re
    }

    #[inline(always)]
    fn eps(&self) -> &[T; N] {
        &self.eps
    }
}

impl<T: Scalar, const N: usize> From<f64> for Dual<T, N> {
    #[inline(always)]
    fn from(re: f64) -> Self {
        Self::constant_of(T::from(re))
    }
}

impl<T: Scalar, const N: usize> Add for Dual<T, N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.apply(other, |x, other| x.zip(other, T::add))
    }
}

impl<T: Scalar, const N: usize> Sub for Dual<T, N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.apply(other, |x, other| x.zip(other, T::sub))
    }
}

impl<T: Scalar, const N: usize> Mul for Dual<T, N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.combine(other.re, other, self.re, self.re * other.re)
    }
}

impl<T: Scalar, const N: usize> Div for Dual<T, N> {
    type Output = Self;
    /// d(x / y) = dx / y − x dy / y².
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let inverse = T::one() / other.re;
        let quotient = self.re / other.re;
        self.combine(inverse, other, -(quotient * inverse), quotient)
    }
}

impl<T: Scalar, const N: usize> Neg for Dual<T, N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.apply((), |x, ()| x.each(T::neg))
    }
}

impl<T: Scalar, const N: usize> Add<f64> for Dual<T, N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: f64) -> Self {
        Self::new(self.re + other, self.eps)
    }
}

impl<T: Scalar, const N: usize> Sub<f64> for Dual<T, N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: f64) -> Self {
        Self::new(self.re - other, self.eps)
    }
}

impl<T: Scalar, const N: usize> Mul<f64> for Dual<T, N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        self.apply(other, |x, other| x.each(|x| x * other))
    }
}

impl<T: Scalar, const N: usize> Div<f64> for Dual<T, N> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: f64) -> Self {
        let inverse = 1.0 / other;
        Self::new(self.re / other, each(|i| self.eps[i] * inverse))
    }
}

/// Operators that change their left side.
macro_rules! assign {
    ($($operator:ident $method:ident $binary:ident;)*) => {$(
        impl<T: Scalar, const N: usize> $operator for Dual<T, N> {
            #[inline(always)]
            fn $method(&mut self, other: Self) {
                *self = self.$binary(other);
            }
        }
    )*};
}
assign! {
    AddAssign add_assign add;
    SubAssign sub_assign sub;
    MulAssign mul_assign mul;
    DivAssign div_assign div;
}

impl<T: Scalar, const N: usize> Zero for Dual<T, N> {
    #[inline(always)]
    fn zero() -> Self {
        Self::constant_of(T::zero())
    }

    #[inline]
    fn is_zero(&self) -> bool {
        self.re.is_zero() && self.eps.iter().all(T::is_zero)
    }
}

impl<T: Scalar, const N: usize> One for Dual<T, N> {
    #[inline(always)]
    fn one() -> Self {
        Self::constant_of(T::one())
    }
}

impl<T: Scalar, const N: usize> Scalar for Dual<T, N> {
    const LANES: usize = T::LANES;
    // Over what is more than values, as intervals and graphs are, a dual number cannot be taken apart either.
    const ORDER: usize = if T::IS_VALUES || T::ORDER > 0 {
        T::ORDER + 1
    } else {
        0
    };
    const IS_VALUES: bool = T::IS_VALUES;
    const HAS_VALUES: bool = T::HAS_VALUES;

    #[inline(always)]
    fn value(&self, lane: usize) -> f64 {
        self.re.value(lane)
    }

    #[inline(always)]
    fn has_value(&self) -> bool {
        self.re.has_value()
    }

    #[inline(always)]
    fn detached(self) -> Self {
        Self::constant_of(self.re.detached())
    }

    #[inline(always)]
    fn is_at_most(&self, limit: f64, condition: &str) -> bool {
        self.re.is_at_most(limit, condition)
    }

    #[inline(always)]
    fn from_values(value: impl FnMut(usize) -> f64) -> Self {
        Self::constant_of(T::from_values(value))
    }

    #[inline(always)]
    fn vectorized<R>(work: impl FnOnce() -> R) -> R {
        T::vectorized(work)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.re.sqrt();
        self.chain(root, T::from(0.5) / root)
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.re.sin_cos();
        (self.chain(sin, cos), self.chain(cos, -sin))
    }

    fn sin_cos_each(x: &[Self], out: &mut [(Self, Self)]) {
        for first in (0..x.len()).step_by(ANGLES) {
            let count = ANGLES.min(x.len() - first);
            let (x, out) = (&x[first..][..count], &mut out[first..][..count]);
            let (mut angles, mut values) = ([T::zero(); ANGLES], [(T::zero(), T::one()); ANGLES]);
            for i in 0..count {
                angles[i] = x[i].re;
            }
            T::sin_cos_each(&angles, &mut values);
            for i in 0..count {
                let (sin, cos) = values[i];
                out[i] = (x[i].chain(sin, cos), x[i].chain(cos, -sin));
            }
        }
    }

    fn exp(self) -> Self {
        let value = self.re.exp();
        self.chain(value, value)
    }

    fn ln(self) -> Self {
        self.chain(self.re.ln(), T::one() / self.re)
    }

    /// d atan2(y, x) = (x dy − y dx) / (x² + y²), the quotients formed by the larger of the two, whose square may
    /// overflow.
    fn atan2(self, x: Self) -> Self {
        let largest = self.re.abs().max(x.re.abs());
        let (sin, cos) = (self.re / largest, x.re / largest);
        let by_square = T::one() / (sin.mul_add(sin, cos * cos) * largest);
        self.combine(cos * by_square, x, -(sin * by_square), self.re.atan2(x.re))
    }

    fn asin(self) -> Self {
        self.chain(self.re.asin(), T::one() / cosine(self.re))
    }

    fn acos(self) -> Self {
        self.chain(self.re.acos(), -(T::one() / cosine(self.re)))
    }

    /// d tanh x = 4 e / (1 + e)² dx with e = e⁻²ˣ for a positive x, which has all its digits however flat it is.
    fn tanh(self) -> Self {
        let e = (self.re.abs() * -2.0).exp();
        let below = e + 1.0;
        self.chain(self.re.tanh(), e * 4.0 / (below * below))
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        self.apply((factor, term), |x, (factor, term)| {
            let re = x.re.mul_add(factor.re, term.re);
            let eps = each(|i| {
                let rest = factor.eps[i].mul_add(x.re, term.eps[i]);
                x.eps[i].mul_add(factor.re, rest)
            });
            Self::new(re, eps)
        })
    }

    #[inline(always)]
    fn mul_add_real(self, factor: f64, term: Self) -> Self {
        self.apply((factor, term), |x, (factor, term)| {
            x.zip(term, |x, term| x.mul_add_real(factor, term))
        })
    }

    #[inline(always)]
    fn scale_add<X: Over<Self>>(self, x: X, term: X) -> X {
        // Duals over these would multiply by derivatives of zero.
        if X::ORDER == Self::ORDER {
            x.mul_add(X::from(self), term)
        } else {
            x * self + term
        }
    }

    #[inline(always)]
    fn select_lt(self, other: Self, a: Self, b: Self) -> Self {
        a.apply((b, self.re, other.re), |a, (b, x, y)| {
            a.zip(b, |a, b| x.select_lt(y, a, b))
        })
    }
}
