//! Numbers in single precision.

use dualbody::Scalar;
use dualbody::scalar::{One, Zero};
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// A number with 24 bits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Single(pub(super) f32);

impl From<f64> for Single {
    fn from(x: f64) -> Self {
        Self(x as f32)
    }
}

super::operators! {
    Single;
    Add add AddAssign add_assign |a: Single, b: Single| Single(a.0 + b.0);
    Sub sub SubAssign sub_assign |a: Single, b: Single| Single(a.0 - b.0);
    Mul mul MulAssign mul_assign |a: Single, b: Single| Single(a.0 * b.0);
    Div div DivAssign div_assign |a: Single, b: Single| Single(a.0 / b.0);
}

impl Neg for Single {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Scalar for Single {
    fn value(&self, _: usize) -> f64 {
        f64::from(self.0)
    }

    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }

    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.0.sin_cos();
        (Self(sin), Self(cos))
    }

    fn exp(self) -> Self {
        Self(self.0.exp())
    }

    fn ln(self) -> Self {
        Self(self.0.ln())
    }

    fn atan2(self, x: Self) -> Self {
        Self(self.0.atan2(x.0))
    }

    fn select_lt(self, other: Self, a: Self, b: Self) -> Self {
        if self.0 < other.0 { a } else { b }
    }
}

dualbody::differentiable! { [] Single; }
