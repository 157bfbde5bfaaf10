//! Intervals, rounded outward: the result contains the results for all numbers in them.

use dualbody::Scalar;
use dualbody::scalar::{One, Zero};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// All numbers from `low` to `high`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Interval {
    pub(super) low: f64,
    pub(super) high: f64,
}

/// Units in the last place by which functions of the library may be off.
const LIBRARY: usize = 4;

impl Interval {
    pub(super) fn around(x: f64, radius: f64) -> Self {
        Self::outward([x - radius, x + radius], 1)
    }

    pub(super) fn width(self) -> f64 {
        self.high - self.low
    }

    pub(super) fn contains(self, x: f64) -> bool {
        self.low <= x && x <= self.high
    }

    /// The smallest interval that holds the numbers, and some units in the last place more.
    fn outward<const N: usize>(x: [f64; N], units: usize) -> Self {
        if x.iter().any(|x| x.is_nan()) {
            return Self {
                low: f64::NEG_INFINITY,
                high: f64::INFINITY,
            };
        }
        let mut low = x.iter().copied().fold(f64::INFINITY, f64::min);
        let mut high = x.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        for _ in 0..units {
            (low, high) = (low.next_down(), high.next_up());
        }
        Self { low, high }
    }

    fn ends(self, f: impl Fn(f64) -> f64) -> [f64; 2] {
        [f(self.low), f(self.high)]
    }

    /// The results for all pairs of ends.
    fn corners(self, other: Self, f: impl Fn(f64, f64) -> f64) -> [f64; 4] {
        let [a, b] = other.ends(|y| f(self.low, y));
        let [c, d] = other.ends(|y| f(self.high, y));
        [a, b, c, d]
    }

    /// The sine, which is 1 and −1 where an angle of `crest` and of `crest` + π is within.
    fn wave(self, f: fn(f64) -> f64, crest: f64) -> Self {
        let holds = |angle: f64| {
            let turns = ((self.low - angle) / TAU).ceil();
            angle + turns * TAU <= self.high
        };
        let mut out = Self::outward(self.ends(f), LIBRARY);
        if holds(crest) {
            out.high = 1.0;
        }
        if holds(crest + PI) {
            out.low = -1.0;
        }
        out
    }
}

impl From<f64> for Interval {
    fn from(x: f64) -> Self {
        Self { low: x, high: x }
    }
}

fn sum(a: Interval, b: Interval) -> Interval {
    // An exact sum stays exact, so that no width appears where there is none.
    if a == Interval::zero() {
        return b;
    }
    if b == Interval::zero() {
        return a;
    }
    Interval::outward([a.low + b.low, a.high + b.high], 1)
}

fn difference(a: Interval, b: Interval) -> Interval {
    sum(a, -b)
}

fn product(a: Interval, b: Interval) -> Interval {
    if a == Interval::zero() || b == Interval::zero() {
        return Interval::zero();
    }
    if a == Interval::one() {
        return b;
    }
    if b == Interval::one() {
        return a;
    }
    Interval::outward(a.corners(b, |a, b| a * b), 1)
}

fn quotient(a: Interval, b: Interval) -> Interval {
    if b.contains(0.0) {
        return Interval::outward([f64::NAN], 0);
    }
    Interval::outward(a.corners(b, |a, b| a / b), 1)
}

super::operators! {
    Interval;
    Add add AddAssign add_assign sum;
    Sub sub SubAssign sub_assign difference;
    Mul mul MulAssign mul_assign product;
    Div div DivAssign div_assign quotient;
}

impl Neg for Interval {
    type Output = Self;
    fn neg(self) -> Self {
        Self {
            low: -self.high,
            high: -self.low,
        }
    }
}

impl Scalar for Interval {
    fn value(&self, _: usize) -> f64 {
        0.5 * (self.low + self.high)
    }

    fn sqrt(self) -> Self {
        Self::outward(self.ends(f64::sqrt), 1)
    }

    fn sin_cos(self) -> (Self, Self) {
        (self.wave(f64::sin, FRAC_PI_2), self.wave(f64::cos, 0.0))
    }

    fn exp(self) -> Self {
        Self::outward(self.ends(f64::exp), LIBRARY)
    }

    fn ln(self) -> Self {
        Self::outward(self.ends(f64::ln), LIBRARY)
    }

    fn atan2(self, x: Self) -> Self {
        if self.contains(0.0) && x.low <= 0.0 {
            return Self { low: -PI, high: PI };
        }
        Self::outward(self.corners(x, f64::atan2), LIBRARY)
    }

    fn select_lt(self, other: Self, a: Self, b: Self) -> Self {
        if self.high < other.low {
            a
        } else if self.low >= other.high {
            b
        } else {
            Self::outward([a.low, a.high, b.low, b.high], 0)
        }
    }
}
