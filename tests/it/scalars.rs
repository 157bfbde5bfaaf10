//! The dual numbers of this crate, operation by operation.

use crate::common::ROUNDING;
use dualbody::autodiff::Dual;
use dualbody::{Lanes, Scalar};
use nalgebra::Vector2;
use num_dual::{Derivative, DualNum, DualSVec64, HyperDual64};
use num_traits::{One, Zero};

type Own = Dual<f64, 2>;
type Theirs = DualSVec64<2>;

fn parts(x: Theirs) -> [f64; 3] {
    let eps = x.eps.0.unwrap_or_default();
    [x.re, eps[0], eps[1]]
}

/// Compares one function over both types at two numbers with derivatives in two directions.
#[track_caller]
fn assert_same(own: impl Fn(Own, Own) -> Own, theirs: impl Fn(Theirs, Theirs) -> Theirs) {
    for (x, y) in [(0.7, -1.3), (2.5, 0.4), (1e-3, 30.0)] {
        let (dx, dy) = ([0.6, -0.2], [1.5, 0.9]);
        let a = own(Own::new(x, dx), Own::new(y, dy));
        let dual = |re, eps: [f64; 2]| Theirs::new(re, Derivative::some(Vector2::from(eps)));
        let b = parts(theirs(dual(x, dx), dual(y, dy)));
        for (a, b) in [a.re, a.eps[0], a.eps[1]].into_iter().zip(b) {
            assert!(
                (a - b).abs() <= ROUNDING * (1.0 + b.abs()),
                "at ({x}, {y}): {a} against {b}"
            );
        }
    }
}

#[test]
fn operators_of_dual_equal_those_of_num_dual() {
    assert_same(|x, y| x + y, |x, y| x + y);
    assert_same(|x, y| x - y, |x, y| x - y);
    assert_same(|x, y| x * y, |x, y| x * y);
    assert_same(|x, y| x / y, |x, y| x / y);
    assert_same(|x, _| -x, |x, _| -x);
    assert_same(|x, _| x + 0.3, |x, _| x + 0.3);
    assert_same(|x, _| x - 0.3, |x, _| x - 0.3);
    assert_same(|x, _| x * 0.3, |x, _| x * 0.3);
    assert_same(|x, _| x / 0.3, |x, _| x / 0.3);
    fn changed<T: Scalar>(mut x: T, y: T) -> T {
        x += y;
        x *= y;
        x -= y * 0.5;
        x /= y;
        x
    }
    assert_same(changed, changed);
}

#[test]
fn functions_of_dual_equal_those_of_num_dual() {
    assert_same(|x, _| Scalar::tan(x), |x, _| DualNum::tan(&x));
    assert_same(|x, _| Scalar::tanh(x), |x, _| DualNum::tanh(&x));
    assert_same(|x, _| Scalar::powi(x, 5), |x, _| DualNum::powi(&x, 5));
    assert_same(|x, _| Scalar::powi(x, -2), |x, _| DualNum::powi(&x, -2));
    assert_same(
        |x, _| Scalar::asin(x * 0.3),
        |x, _| DualNum::asin(&(x * 0.3)),
    );
    assert_same(
        |x, _| Scalar::acos(x * 0.3),
        |x, _| DualNum::acos(&(x * 0.3)),
    );
    assert_same(|x, _| Scalar::sqrt(x), |x, _| DualNum::sqrt(&x));
    assert_same(|x, _| Scalar::sin_cos(x).0, |x, _| DualNum::sin(&x));
    assert_same(|x, _| Scalar::sin_cos(x).1, |x, _| DualNum::cos(&x));
    assert_same(|_, y| Scalar::exp(y * 0.1), |_, y| DualNum::exp(&(y * 0.1)));
    assert_same(|x, _| Scalar::ln(x), |x, _| DualNum::ln(&x));
    assert_same(|x, y| Scalar::atan2(y, x), |x, y| DualNum::atan2(&y, x));
    assert_same(|x, y| Scalar::mul_add(x, y, x), |x, y| x * y + x);
    assert_same(|x, y| Scalar::mul_add_real(x, 0.3, y), |x, y| x * 0.3 + y);
    assert_same(|x, y| Scalar::scale_add(x, y, x), |x, y| y * x + x);
    assert_same(|x, y| Scalar::scale_add(0.3, x, y), |x, y| x * 0.3 + y);
    assert_same(
        |x, y| Scalar::select_lt(x, y, x * y, -x),
        |x, y| if x.re < y.re { x * y } else { -x },
    );
}

// (√x)' = 1 / 2√x, (1 / x)' = −1 / x², sin' = cos, cos' = −sin, exp' = exp, ln' = 1 / x
#[test]
fn derivatives_of_dual_equal_closed_forms() {
    let x = Dual::<f64, 1>::variable(0.8, 0);
    let slope = |y: Dual<f64, 1>, expected: f64| {
        assert!(
            (y.eps[0] - expected).abs() < ROUNDING,
            "{y:?}, not {expected}"
        );
    };
    slope(Scalar::sqrt(x), 0.5 / 0.8_f64.sqrt());
    slope(Dual::one() / x, -1.0 / 0.64);
    slope(Scalar::sin_cos(x).0, 0.8_f64.cos());
    slope(Scalar::sin_cos(x).1, -0.8_f64.sin());
    slope(Scalar::exp(x), 0.8_f64.exp());
    slope(Scalar::ln(x), 1.0 / 0.8);
    slope(x * x * x, 3.0 * 0.64);
}

// Where a side is chosen, or where an angle passes an axis, value and derivative are those of the chosen side.
#[test]
fn derivatives_of_dual_at_singular_points_equal_closed_forms() {
    let x = |re: f64| Dual::<f64, 1>::variable(re, 0);
    let real = Dual::<f64, 1>::from;
    let parts = |y: Dual<f64, 1>| (y.re, y.eps[0]);
    assert_eq!(parts(Scalar::abs(x(0.0))), (0.0, 1.0));
    assert_eq!(parts(Scalar::abs(x(-2.0))), (2.0, -1.0));
    assert_eq!(parts(Scalar::min(x(1.0), real(1.0))), (1.0, 0.0));
    assert_eq!(parts(Scalar::max(x(1.0), real(1.0))), (1.0, 0.0));
    assert_eq!(parts(Scalar::clamp(x(3.0), -1.0, 1.0)), (1.0, 0.0));
    assert_eq!(parts(Scalar::sin_cos(x(0.0)).0), (0.0, 1.0));
    assert_eq!(parts(Scalar::sin_cos(x(0.0)).1).1.abs(), 0.0);
    // atan2(y, x) on the axes: dθ/dy = x / r²
    use std::f64::consts::{FRAC_PI_2, PI};
    assert_eq!(parts(Scalar::atan2(x(0.0), real(2.0))), (0.0, 0.5));
    assert_eq!(parts(Scalar::atan2(x(0.0), real(-2.0))), (PI, -0.5));
    assert_eq!(parts(Scalar::atan2(x(2.0), real(0.0))), (FRAC_PI_2, 0.0));
    // … and far out, where the squared length would overflow: dθ/dx = −y / r²
    assert_eq!(
        parts(Scalar::atan2(real(2e200), x(0.0))),
        (FRAC_PI_2, -0.5e-200)
    );
    assert!(Dual::<f64, 1>::zero().is_zero() && !x(0.0).is_zero());
}

/// A function of two numbers over any scalar.
type Function<T> = fn(T, T) -> T;

/// Functions with second derivatives at any two positive numbers below one.
fn functions<T: Scalar>() -> [(&'static str, Function<T>); 12] {
    [
        ("product", |x, y| x * y * x),
        ("quotient", |x, y| x / (y + 2.0)),
        ("root", |x, y| (x * x + y).sqrt()),
        ("sine", |x, y| (x * y).sin_cos().0),
        ("cosine", |x, y| (x + y).sin_cos().1),
        ("exponential", |x, y| (x * y).exp()),
        ("logarithm", |x, y| (x + y * y).ln()),
        ("angle", |x, y| (-y).atan2(x)),
        ("arcsine", |x, y| Scalar::asin(x * y)),
        ("arccosine", |x, y| Scalar::acos(x * y)),
        ("hyperbolic tangent", |x, y| Scalar::tanh(x - y)),
        ("smaller of two", |x, y| Scalar::min(x * x, y)),
    ]
}

// num-dual differentiates twice by types of its own.
#[test]
fn duals_over_duals_equal_hyper_dual_numbers() {
    type Twice = Dual<Dual<f64, 1>, 1>;
    let twice =
        |x: f64, first: f64, second: f64| Twice::new(Dual::new(x, [second]), [Dual::from(first)]);
    let named = functions::<Twice>()
        .into_iter()
        .zip(functions::<HyperDual64>());
    for ((name, own), (_, theirs)) in named {
        for (x, y) in [(0.7, 0.4), (0.2, 0.9)] {
            let a = own(twice(x, 1.0, 0.3), twice(y, -0.5, 2.0));
            let e = theirs(
                HyperDual64::new(x, 1.0, 0.3, 0.0),
                HyperDual64::new(y, -0.5, 2.0, 0.0),
            );
            let parts = [
                (a.re.re, e.re),
                (a.eps[0].re, e.eps1),
                (a.re.eps[0], e.eps2),
                (a.eps[0].eps[0], e.eps1eps2),
            ];
            for (a, e) in parts {
                assert!(
                    (a - e).abs() <= 1e-13 * e.abs().max(1.0),
                    "{name}: {a}, not {e}"
                );
            }
        }
    }
}

#[test]
fn duals_over_lanes_equal_duals_of_each_lane() {
    type Side = Dual<Lanes<2>, 1>;
    let (x, y) = (Lanes([0.7, 0.2]), Lanes([0.4, 0.9]));
    let named = functions::<Side>()
        .into_iter()
        .zip(functions::<Dual<f64, 1>>());
    for ((name, side), (_, single)) in named {
        let all = side(
            Side::new(x, [Lanes([1.0, 0.3])]),
            Side::new(y, [Lanes([-0.5, 2.0])]),
        );
        for (lane, (dx, dy)) in [(1.0, -0.5), (0.3, 2.0)].into_iter().enumerate() {
            let own = single(Dual::new(x.0[lane], [dx]), Dual::new(y.0[lane], [dy]));
            let at = (all.re.0[lane], all.eps[0].0[lane]);
            assert_eq!(at, (own.re, own.eps[0]), "{name}, lane {lane}");
        }
    }
}
