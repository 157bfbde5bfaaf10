//! A dual number with a fixed number of directions, in plain arrays.
//!
//! The vector types of `num-dual` keep their derivative part optional, which costs a branch in every operation and keeps compilers
//! from vector instructions. This type always has its `N` derivatives, and is what the drivers of this crate use inside. Both are
//! scalars, and give the same numbers.

use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

use num_traits::{One, Zero};

use crate::scalar::{Over, Scalar, sin_cos_each};

/// x + Σᵢ εᵢ dᵢ with εᵢ εⱼ = 0: a value with its derivatives in `N` directions.
///
/// # Examples
/// ```
/// use dualbody::{Scalar, autodiff::Dual};
///
/// // d/dx x² sin x = 2 x sin x + x² cos x
/// let x = Dual::<1>::variable(0.5, 0);
/// let y = x * x * x.sin_cos().0;
/// assert!((y.eps[0] - (0.5_f64.sin() + 0.25 * 0.5_f64.cos())).abs() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual<const N: usize> {
    /// The value.
    pub re: f64,
    /// The derivatives, one for each direction.
    pub eps: [f64; N],
}

impl<const N: usize> Dual<N> {
    /// A number with its derivatives.
    #[inline(always)]
    pub fn new(re: f64, eps: [f64; N]) -> Self {
        Self { re, eps }
    }

    /// The variable of a direction: derivative one in it, zero in the others.
    ///
    /// # Panics
    /// If there is no such direction.
    #[inline(always)]
    pub fn variable(re: f64, direction: usize) -> Self {
        let mut out = Self::from(re);
        out.eps[direction] = 1.0;
        out
    }

    /// f(x) from f's value and derivative at x.
    #[inline(always)]
    fn chain(self, value: f64, derivative: f64) -> Self {
        Self::new(value, each(|i| self.eps[i] * derivative))
    }

    /// `a` d(self) + `b` d(other) with the value `re`.
    #[inline(always)]
    fn combine(self, a: f64, other: Self, b: f64, re: f64) -> Self {
        let eps = each(|i| Scalar::mul_add(self.eps[i], a, other.eps[i] * b));
        Self::new(re, eps)
    }
}

/// The cosine, not negative, of an angle with this sine, or the other way round.
fn cosine(sine: f64) -> f64 {
    ((1.0 - sine) * (1.0 + sine)).sqrt()
}

/// A loop rather than `std::array::from_fn`, whose closures are not always inlined.
#[inline(always)]
fn each<const N: usize>(f: impl Fn(usize) -> f64) -> [f64; N] {
    let mut out = [0.0; N];
    for i in 0..N {
        out[i] = f(i);
    }
    out
}

impl<const N: usize> From<f64> for Dual<N> {
    #[inline(always)]
    fn from(re: f64) -> Self {
        Self::new(re, [0.0; N])
    }
}

impl<const N: usize> Add for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let eps = each(|i| self.eps[i] + other.eps[i]);
        Self::new(self.re + other.re, eps)
    }
}

impl<const N: usize> Sub for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        let eps = each(|i| self.eps[i] - other.eps[i]);
        Self::new(self.re - other.re, eps)
    }
}

impl<const N: usize> Mul for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.combine(other.re, other, self.re, self.re * other.re)
    }
}

impl<const N: usize> Div for Dual<N> {
    type Output = Self;
    /// d(x / y) = dx / y − x dy / y².
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let inverse = 1.0 / other.re;
        let quotient = self.re / other.re;
        self.combine(inverse, other, -(quotient * inverse), quotient)
    }
}

impl<const N: usize> Neg for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(-self.re, each(|i| -self.eps[i]))
    }
}

impl<const N: usize> Add<f64> for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: f64) -> Self {
        Self::new(self.re + other, self.eps)
    }
}

impl<const N: usize> Sub<f64> for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: f64) -> Self {
        Self::new(self.re - other, self.eps)
    }
}

impl<const N: usize> Mul<f64> for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        self.chain(self.re * other, other)
    }
}

impl<const N: usize> Div<f64> for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: f64) -> Self {
        self.chain(self.re / other, 1.0 / other)
    }
}

/// Operators that change their left side.
macro_rules! assign {
    ($($operator:ident $method:ident $binary:ident;)*) => {$(
        impl<const N: usize> $operator for Dual<N> {
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

impl<const N: usize> Zero for Dual<N> {
    #[inline(always)]
    fn zero() -> Self {
        Self::from(0.0)
    }

    fn is_zero(&self) -> bool {
        self.re == 0.0 && self.eps.iter().all(|&eps| eps == 0.0)
    }
}

impl<const N: usize> One for Dual<N> {
    #[inline(always)]
    fn one() -> Self {
        Self::from(1.0)
    }
}

impl<const N: usize> Scalar for Dual<N> {
    const ORDER: usize = 1;

    #[inline(always)]
    fn value(&self, lane: usize) -> f64 {
        assert_eq!(lane, 0, "there is one lane");
        self.re
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.re.sqrt();
        self.chain(root, 0.5 / root)
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = Scalar::sin_cos(self.re);
        (self.chain(sin, cos), self.chain(cos, -sin))
    }

    fn sin_cos_each(x: &[Self], out: &mut [(Self, Self)]) {
        let apply = |x: &Self, sin, cos| (x.chain(sin, cos), x.chain(cos, -sin));
        sin_cos_each(x, out, |x| x.re, apply);
    }

    fn exp(self) -> Self {
        let value = self.re.exp();
        self.chain(value, value)
    }

    fn ln(self) -> Self {
        self.chain(self.re.ln(), 1.0 / self.re)
    }

    /// d atan2(y, x) = (x dy − y dx) / (x² + y²), the quotients formed by the length, which does not overflow.
    fn atan2(self, x: Self) -> Self {
        let length = self.re.hypot(x.re);
        let (sin, cos) = (self.re / length, x.re / length);
        self.combine(cos / length, x, -(sin / length), self.re.atan2(x.re))
    }

    fn asin(self) -> Self {
        self.chain(self.re.asin(), 1.0 / cosine(self.re))
    }

    fn acos(self) -> Self {
        self.chain(self.re.acos(), -1.0 / cosine(self.re))
    }

    /// d tanh x = 4 e / (1 + e)² dx with e = e⁻²ˣ for a positive x, which has all its digits however flat it is.
    fn tanh(self) -> Self {
        let e = (-2.0 * self.re.abs()).exp();
        self.chain(self.re.tanh(), 4.0 * e / ((1.0 + e) * (1.0 + e)))
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        let re = Scalar::mul_add(self.re, factor.re, term.re);
        let eps = each(|i| {
            let rest = Scalar::mul_add(factor.eps[i], self.re, term.eps[i]);
            Scalar::mul_add(self.eps[i], factor.re, rest)
        });
        Self::new(re, eps)
    }

    #[inline(always)]
    fn mul_add_real(self, factor: f64, term: Self) -> Self {
        let eps = each(|i| Scalar::mul_add(self.eps[i], factor, term.eps[i]));
        Self::new(Scalar::mul_add(self.re, factor, term.re), eps)
    }

    #[inline(always)]
    fn scale_add<T: Over<Self>>(self, x: T, term: T) -> T {
        x.mul_add(T::from(self), term)
    }

    #[inline(always)]
    fn select_lt(self, other: Self, a: Self, b: Self) -> Self {
        if self.re < other.re { a } else { b }
    }
}
