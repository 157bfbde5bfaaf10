//! Several numbers in one scalar, for the vector units of a CPU.

use crate::scalar::from_each;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

use num_traits::{One, Zero};

use super::each::each_lane;
use super::float::Float;
use super::vectorized::{has_lanes, vectorized, vectorized_lanes};
use super::{Over, Scalar};

/// `N` independent real numbers with the same operations: one lane for each of `N` states or models.
///
/// All operations act lane by lane and are bit-identical to those of `f64`, except `exp`, `ln` and `atan2` on a target whose library differs. The
/// type is a plain array: the compiler makes vector instructions of the width of the target. It is aligned, so that no vector crosses a cache line
/// unnecessarily.
///
/// Optimised programs for x86-64 need a CPU with AVX2 for the dynamics over lanes, and panic on others; there
/// [`BatchSimulator`](crate::sim::BatchSimulator) steps its states one by one, with bit-identical results.
///
/// # Examples
/// ```
/// use dualbody::{Lanes, Scalar, dynamics::potential_energy, model::samples};
///
/// // Two pendulums at once: hanging, and horizontal half a metre higher.
/// let energy = potential_energy(&samples::pendulum(), &[Lanes([0.0, std::f64::consts::FRAC_PI_2])]);
/// assert!((energy.0[1] - energy.0[0] - 0.5 * 9.81).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(32))]
pub struct Lanes<const N: usize>(pub [f64; N]);

/// [`Lanes`] in single precision: twice as many fit into a vector register, with 7 digits instead of 16.
///
/// All of the physics runs on it, as on any scalar; solvers on values (the forces of rigid contact and of constraints) run in double precision and
/// round their result. See [`SingleBatch`](crate::sim::SingleBatch) for the accuracy of states.
///
/// # Examples
/// ```
/// use dualbody::{dynamics::potential_energy, model::samples, scalar::SingleLanes};
///
/// let energy = potential_energy(&samples::pendulum(), &[SingleLanes([0.0, std::f32::consts::FRAC_PI_2])]);
/// assert!((energy.0[1] - energy.0[0] - 0.5 * 9.81).abs() < 1e-6);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(32))]
pub struct SingleLanes<const N: usize>(pub [f32; N]);

impl<const N: usize> Lanes<N> {
    /// Whether the dynamics run over lanes on this CPU: always, except in optimised programs for x86-64 on a CPU without AVX2, where they panic. On
    /// such a CPU [`BatchSimulator`](crate::sim::BatchSimulator) steps its states one by one, with bit-identical results.
    pub fn is_supported() -> bool {
        has_lanes()
    }
}

/// Operators between two numbers of lanes, and with `f64` on the right.
macro_rules! operators {
    ($name:ident of $float:ident: $($operator:ident $method:ident $assign:ident $assign_method:ident;)*) => {$(
        impl<const N: usize> $operator for $name<N> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.zip(other, $float::$method)
            }
        }
        impl<const N: usize> $operator<f64> for $name<N> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: f64) -> Self {
                self.map(|x| x.$method($float::of(other)))
            }
        }
        impl<const N: usize> $assign for $name<N> {
            #[inline(always)]
            fn $assign_method(&mut self, other: Self) {
                *self = self.$method(other);
            }
        }
    )*};
}

/// Makes a type of lanes a scalar, each of whose operations acts lane by lane.
macro_rules! lanes {
    ($($name:ident of $float:ident, $vectorized:expr;)*) => {$(
impl<const N: usize> $name<N> {
    #[inline(always)]
    fn each(f: impl Fn(usize) -> $float) -> Self {
        Self(each_lane(f))
    }

    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn($float, $float) -> $float) -> Self {
        Self::each(|i| f(self.0[i], other.0[i]))
    }

    #[inline(always)]
    fn map(self, f: impl Fn($float) -> $float) -> Self {
        Self::each(|i| f(self.0[i]))
    }
}

impl<const N: usize> Default for $name<N> {
    fn default() -> Self {
        Self::zero()
    }
}

impl<const N: usize> From<f64> for $name<N> {
    #[inline(always)]
    fn from(x: f64) -> Self {
        Self([$float::of(x); N])
    }
}

impl<const N: usize> Neg for $name<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map($float::neg)
    }
}

impl<const N: usize> Zero for $name<N> {
    #[inline(always)]
    fn zero() -> Self {
        Self([0.0; N])
    }

    #[inline]
    fn is_zero(&self) -> bool {
        self.0.iter().all(|&x| x == 0.0)
    }
}

impl<const N: usize> One for $name<N> {
    #[inline(always)]
    fn one() -> Self {
        Self([1.0; N])
    }
}

impl<const N: usize> Scalar for $name<N> {
    const LANES: usize = N;
    const IS_VALUES: bool = true;

    #[inline(always)]
    fn value(&self, lane: usize) -> f64 {
        self.0[lane].widened()
    }

    #[inline(always)]
    fn from_values(mut value: impl FnMut(usize) -> f64) -> Self {
        Self(from_each(|lane| $float::of(value(lane))))
    }

    #[inline(always)]
    fn vectorized<R>(work: impl FnOnce() -> R) -> R {
        $vectorized(work)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.map($float::sqrt)
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = $float::sines_and_cosines(self.0);
        (Self(sin), Self(cos))
    }

    fn exp(self) -> Self {
        self.map($float::exp)
    }

    fn ln(self) -> Self {
        self.map($float::ln)
    }

    fn atan2(self, x: Self) -> Self {
        self.zip(x, $float::atan2)
    }

    fn asin(self) -> Self {
        self.map($float::asin)
    }

    fn acos(self) -> Self {
        self.map($float::acos)
    }

    fn tanh(self) -> Self {
        self.map($float::tanh)
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        Self::each(|i| Float::fused(self.0[i], factor.0[i], term.0[i]))
    }

    #[inline(always)]
    fn mul_add_real(self, factor: f64, term: Self) -> Self {
        let factor = $float::of(factor);
        Self::each(|i| Float::fused(self.0[i], factor, term.0[i]))
    }

    #[inline(always)]
    fn scale_add<T: Over<Self>>(self, x: T, term: T) -> T {
        // Duals over lanes would multiply by derivatives of zero.
        if T::ORDER == Self::ORDER {
            x.mul_add(T::from(self), term)
        } else {
            x * self + term
        }
    }

    #[inline(always)]
    fn select_lt(self, other: Self, a: Self, b: Self) -> Self {
        Self::each(|i| {
            if self.0[i] < other.0[i] {
                a.0[i]
            } else {
                b.0[i]
            }
        })
    }
}

operators! {
    $name of $float:
    Add add AddAssign add_assign;
    Sub sub SubAssign sub_assign;
    Mul mul MulAssign mul_assign;
    Div div DivAssign div_assign;
}
    )*};
}
lanes! {
    Lanes of f64, vectorized_lanes::<_, N>;
    SingleLanes of f32, vectorized;
}

#[cfg(test)]
mod tests {
    use super::*;

    const X: [f64; 5] = [0.3, -2.5, 0.0, -0.0, 1e7];
    const Y: [f64; 5] = [-0.7, 1.1, 3.0, 0.0, -1e-3];

    #[track_caller]
    fn assert_lanes(lanes: Lanes<5>, single: impl Fn(f64, f64) -> f64) {
        // The sign of NaN depends on when it is computed.
        let bits = |x: [f64; 5]| x.map(|x| if x.is_nan() { u64::MAX } else { x.to_bits() });
        let singles = std::array::from_fn(|i| single(X[i], Y[i]));
        assert_eq!(bits(lanes.0), bits(singles), "{lanes:?}, not {singles:?}");
    }

    #[test]
    fn operators_equal_those_of_f64_bit_for_bit() {
        let (x, y) = (Lanes(X), Lanes(Y));
        assert_lanes(x + y, |x, y| x + y);
        assert_lanes(x - y, |x, y| x - y);
        assert_lanes(x * y, |x, y| x * y);
        assert_lanes(y / x, |x, y| y / x);
        assert_lanes(-x, |x, _| -x);
        assert_lanes(x + 0.1, |x, _| x + 0.1);
        assert_lanes(x - 0.1, |x, _| x - 0.1);
        assert_lanes(x * 0.1, |x, _| x * 0.1);
        assert_lanes(x / 0.1, |x, _| x / 0.1);
        let changed = |change: fn(&mut Lanes<5>, Lanes<5>)| {
            let mut x = x;
            change(&mut x, y);
            x
        };
        assert_lanes(changed(|x, y| *x += y), |x, y| x + y);
        assert_lanes(changed(|x, y| *x -= y), |x, y| x - y);
        assert_lanes(changed(|x, y| *x *= y), |x, y| x * y);
        assert_lanes(changed(|x, y| *x /= y), |x, y| x / y);
    }

    #[test]
    fn functions_equal_those_of_f64_bit_for_bit() {
        let (x, y) = (Lanes(X), Lanes(Y));
        assert_lanes((x * x).sqrt(), |x, _| (x * x).sqrt());
        assert_lanes(x.sin_cos().0, |x, _| Scalar::sin_cos(x).0);
        assert_lanes(x.sin_cos().1, |x, _| Scalar::sin_cos(x).1);
        assert_lanes(y.exp(), |_, y| y.exp());
        assert_lanes((x * x).ln(), |x, _| (x * x).ln());
        assert_lanes(y.atan2(x), |x, y| y.atan2(x));
        assert_lanes(x.tan(), |x, _| Scalar::tan(x));
        assert_lanes(x.sin_cos().0.asin(), |x, _| Scalar::sin_cos(x).0.asin());
        assert_lanes(x.sin_cos().0.acos(), |x, _| Scalar::sin_cos(x).0.acos());
        assert_lanes(y.tanh(), |_, y| y.tanh());
        assert_lanes(y.powi(-3), |_, y| Scalar::powi(y, -3));
        assert_lanes(x.mul_add(y, y), |x, y| Scalar::mul_add(x, y, y));
        assert_lanes(x.mul_add_real(0.1, y), |x, y| {
            Scalar::mul_add_real(x, 0.1, y)
        });
        assert_lanes(x.scale_add(y, x), |x, y| Scalar::scale_add(x, y, x));
        assert_lanes(0.1.scale_add(y, x), |x, y| Scalar::scale_add(0.1, y, x));
        assert_lanes(x.select_lt(y, x, -y), |x, y| if x < y { x } else { -y });
        assert_lanes(x.abs(), |x, _| Scalar::abs(x));
        assert_lanes(Scalar::min(x, y), Scalar::min);
        assert_lanes(Scalar::max(x, y), Scalar::max);
        assert_lanes(x.clamp(-1.0, 2.0), |x, _| Scalar::clamp(x, -1.0, 2.0));
    }

    #[test]
    fn values_of_the_lanes_make_the_number_again() {
        assert_lanes(Lanes::from_values(|i| Lanes(X).value(i)), |x, _| x);
        assert_eq!((Lanes::<5>::LANES, Lanes::<5>::ORDER), (5, 0));
    }

    // Each operation in single precision is that of `f32`.
    #[test]
    fn single_lanes_equal_numbers_in_single_precision() {
        let (x, y) = (X.map(|x| x as f32), Y.map(|y| y as f32));
        let (a, b) = (SingleLanes(x), SingleLanes(y));
        let each = |f: fn(f32, f32) -> f32| std::array::from_fn(|i| f(x[i], y[i]));
        assert_eq!((a + b).0, each(|x, y| x + y));
        assert_eq!((a - b * 0.1).0, each(|x, y| x - y * 0.1));
        assert_eq!((b / (a + 1.0)).0, each(|x, y| y / (x + 1.0)));
        assert_eq!((a * a).sqrt().0, each(|x, _| (x * x).sqrt()));
        assert_eq!(b.atan2(a).0, each(|x, y| y.atan2(x)));
        assert_eq!(a.select_lt(b, a, b).0, each(f32::min));
        assert_eq!(SingleLanes::<5>::from_values(|i| a.value(i)), a);
        assert!((a.sin_cos().0.0[0] - 0.3_f32.sin()).abs() < 1e-7);
    }

    #[test]
    fn zero_is_zero_in_every_lane() {
        assert!(Lanes::<2>::default().is_zero() && Lanes([0.0, -0.0]).is_zero());
        assert!(!Lanes([0.0, 1.0]).is_zero());
        assert_eq!(Lanes::<2>::one(), Lanes([1.0; 2]));
    }
}
