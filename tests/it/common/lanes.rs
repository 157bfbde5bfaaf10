//! A toy SIMD type: four numbers side by side, without any ordering. Whatever compiles and agrees on it has no branch on a value.

use std::array::from_fn;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

use dualbody::Scalar;
use num_traits::{One, Zero};

pub(crate) const WIDTH: usize = 4;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lanes(pub(crate) [f64; WIDTH]);

impl From<f64> for Lanes {
    fn from(x: f64) -> Self {
        Self([x; WIDTH])
    }
}

impl Zero for Lanes {
    fn zero() -> Self {
        0.0.into()
    }
    fn is_zero(&self) -> bool {
        *self == Self::zero()
    }
}

impl One for Lanes {
    fn one() -> Self {
        1.0.into()
    }
}

impl Neg for Lanes {
    type Output = Self;
    fn neg(self) -> Self {
        Self(self.0.map(|x| -x))
    }
}

macro_rules! operators {
    ($($trait:ident $method:ident $assign_trait:ident $assign:ident $op:tt;)*) => {$(
        impl $trait for Lanes {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                Self(from_fn(|k| self.0[k] $op other.0[k]))
            }
        }
        impl $trait<f64> for Lanes {
            type Output = Self;
            fn $method(self, other: f64) -> Self {
                Self(self.0.map(|x| x $op other))
            }
        }
        impl $assign_trait for Lanes {
            fn $assign(&mut self, other: Self) {
                *self = *self $op other;
            }
        }
    )*};
}

operators! {
    Add add AddAssign add_assign +;
    Sub sub SubAssign sub_assign -;
    Mul mul MulAssign mul_assign *;
    Div div DivAssign div_assign /;
}

impl Scalar for Lanes {
    fn sqrt(self) -> Self {
        Self(self.0.map(f64::sqrt))
    }

    fn sin_cos(self) -> (Self, Self) {
        (Self(self.0.map(f64::sin)), Self(self.0.map(f64::cos)))
    }

    fn exp(self) -> Self {
        Self(self.0.map(f64::exp))
    }

    fn ln(self) -> Self {
        Self(self.0.map(f64::ln))
    }

    fn atan2(self, x: Self) -> Self {
        Self(from_fn(|k| self.0[k].atan2(x.0[k])))
    }

    fn select_lt(self, other: Self, a: Self, b: Self) -> Self {
        Self(from_fn(|k| {
            if self.0[k] < other.0[k] {
                a.0[k]
            } else {
                b.0[k]
            }
        }))
    }
}
