//! Every function gives the same values on every scalar.

use dualbody::autodiff::Dual;
use dualbody::dynamics::forward_dynamics;
use dualbody::model::samples;
use dualbody::{Lanes, Model, Over, Scalar, Simulator, State};
use nalgebra::SVector;
use num_dual::{Derivative, Dual64, DualSVec64, HyperDual64, Real};

use crate::common::everything::everything;
use crate::common::{Point, ROUNDING, SAME_ALGEBRA, random_point, robots};

/// Lanes of the tests.
const WIDTH: usize = dualbody::sim::BATCH_WIDTH;

/// Everything at a point over a scalar with seeded derivatives, of which `value` takes the value.
fn values<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    point: &Point,
    seed: impl Fn(f64) -> T,
    value: impl Fn(T) -> f64,
) -> Vec<f64> {
    let lift = |x: &nalgebra::DVector<f64>| x.iter().map(|&x| seed(x)).collect::<Vec<T>>();
    let (q, v, w) = (lift(&point.q), lift(&point.v), lift(&point.w));
    everything(model, &q, &v, &w)
        .numbers
        .into_iter()
        .map(value)
        .collect()
}

/// Each number to rounding beside the largest of the same function: the sums that give it have terms of that size.
fn assert_same(names: &[&str], actual: &[f64], expected: &[f64], what: &str) {
    assert_eq!(actual.len(), expected.len());
    let largest = |name: &str| {
        let own = names
            .iter()
            .zip(expected)
            .filter(|(other, _)| **other == name);
        own.fold(1.0_f64, |largest, (_, x)| largest.max(x.abs()))
    };
    for ((name, a), e) in names.iter().zip(actual).zip(expected) {
        assert!(
            (a - e).abs() <= SAME_ALGEBRA * largest(name),
            "{what}, {name}: {a} against {e}"
        );
    }
}

#[test]
fn values_on_dual_numbers_equal_those_on_f64() {
    for model in robots() {
        for seed in 0..2 {
            let point = random_point(&model, seed);
            let expected = everything(
                &model,
                point.q.as_slice(),
                point.v.as_slice(),
                point.w.as_slice(),
            );
            let check = |actual: &[f64], scalar: &str| {
                assert_same(
                    &expected.names,
                    actual,
                    &expected.numbers,
                    &format!("{}, seed {seed}, {scalar}", model.name()),
                );
            };
            let dual = |x| Dual64::new(x, 1.0);
            check(&values(&model, &point, dual, |x| x.re), "Dual64");
            check(
                &values(
                    &model,
                    &point,
                    |x| DualSVec64::<4>::from(x).derivative(2),
                    |x| x.re,
                ),
                "DualSVec64<4>",
            );
            check(
                &values(
                    &model,
                    &point,
                    |x| HyperDual64::new(x, 1.0, -1.0, 0.5),
                    |x| x.re,
                ),
                "HyperDual64",
            );
            check(
                &values(&model.cast::<Dual64>(), &point, dual, |x| x.re),
                "Dual64 over a model of Dual64",
            );
        }
    }
}

// Jacobians of a step on numbers of num-dual: their values, and central differences of them along a change of the whole state.
#[test]
fn jacobians_of_steps_on_num_dual_have_the_derivatives_of_those_on_f64() {
    const BY: f64 = 1e-5;
    for model in [samples::arm(), samples::random_tree(6, 3)] {
        let simulator = Simulator::new(model).with_time_step(0.01);
        let (model, u) = (simulator.model(), vec![0.3; simulator.nu()]);
        let point = random_point(model, 5);
        let along = |k: usize| (1.0 + 2.0 * k as f64).cos();
        let dq: Vec<Dual64> = (0..model.nv())
            .map(|k| Dual64::new(0.0, along(k)))
            .collect();
        let q: Vec<Dual64> = point.q.iter().map(|&q| q.into()).collect();
        let v = point.v.iter().enumerate();
        let v: Vec<Dual64> = v.map(|(k, &v)| Dual64::new(v, along(k + 9))).collect();
        let state = State::new(model.integrate(&q, &dq).as_slice(), &v);
        let lifted: Vec<Dual64> = u.iter().map(|&u| u.into()).collect();
        let found = simulator.linearize(&state, &lifted);
        let at = |by: f64| {
            let dq: Vec<f64> = (0..model.nv()).map(|k| by * along(k)).collect();
            let v = point.v.iter().enumerate();
            let v: Vec<f64> = v.map(|(k, v)| v + by * along(k + 9)).collect();
            let q = model.integrate(point.q.as_slice(), &dq);
            simulator.linearize(&State::new(q.as_slice(), &v), &u)
        };
        let [here, after, before] = [0.0, BY, -BY].map(at);
        let slopes = (after.a - before.a) / (2.0 * BY);
        let size = slopes.amax().max(1.0);
        for ((found, value), slope) in found.a.iter().zip(&here.a).zip(&slopes) {
            assert!((found.re - value).abs() < SAME_ALGEBRA * value.abs().max(1.0));
            assert!(
                (found.eps - slope).abs() < 1e-6 * size,
                "{} {slope}",
                found.eps
            );
        }
    }
}

// The plain arrays of `Dual` against the optional derivatives of num-dual, seeded in all directions.
#[test]
fn derivatives_on_dual_equal_those_on_num_dual() {
    let seed = |k: usize, x: f64| {
        let eps = std::array::from_fn(|i| ((3 * k + 2 * i) as f64).sin());
        let other = Derivative::some(SVector::<f64, 4>::from(eps));
        (Dual::<f64, 4>::new(x, eps), DualSVec64::<4>::new(x, other))
    };
    for model in robots() {
        let point = random_point(&model, 7);
        let both = |x: &nalgebra::DVector<f64>, first: usize| -> (Vec<_>, Vec<_>) {
            let seeded = x.iter().enumerate().map(|(k, &x)| seed(first + k, x));
            seeded.unzip()
        };
        let (q, v, w) = (both(&point.q, 0), both(&point.v, 40), both(&point.w, 80));
        let own = everything(&model, &q.0, &v.0, &w.0);
        let theirs = everything(&model, &q.1, &v.1, &w.1);
        for ((name, own), theirs) in own.names.iter().zip(&own.numbers).zip(&theirs.numbers) {
            let eps = theirs.eps.unwrap_generic(nalgebra::Const, nalgebra::Const);
            let numbers = std::iter::once(theirs.re).chain(eps.iter().copied());
            let size = numbers.clone().fold(1.0, |size: f64, x| size.max(x.abs()));
            for (a, e) in std::iter::once(own.re).chain(own.eps).zip(numbers) {
                assert!(
                    (a - e).abs() <= SAME_ALGEBRA * size,
                    "{}, {name}: {a} against {e}",
                    model.name()
                );
            }
        }
    }
}

#[test]
fn lanes_equal_separate_evaluations_bit_for_bit() {
    for model in robots() {
        let points: Vec<Point> = (0..WIDTH as u64)
            .map(|seed| random_point(&model, seed))
            .collect();
        let pack = |of: fn(&Point) -> &nalgebra::DVector<f64>| -> Vec<Lanes<WIDTH>> {
            (0..of(&points[0]).len())
                .map(|i| Lanes(std::array::from_fn(|k| of(&points[k])[i])))
                .collect()
        };
        let packed = everything(&model, &pack(|p| &p.q), &pack(|p| &p.v), &pack(|p| &p.w));
        let over_lanes = everything(
            &model.cast::<Lanes<WIDTH>>(),
            &pack(|p| &p.q),
            &pack(|p| &p.v),
            &pack(|p| &p.w),
        );
        for (k, point) in points.iter().enumerate() {
            let expected = everything(
                &model,
                point.q.as_slice(),
                point.v.as_slice(),
                point.w.as_slice(),
            );
            for (results, what) in [(&packed, "f64"), (&over_lanes, "lanes")] {
                for ((name, x), e) in expected
                    .names
                    .iter()
                    .zip(&results.numbers)
                    .zip(&expected.numbers)
                {
                    assert_eq!(
                        x.0[k].to_bits(),
                        e.to_bits(),
                        "{}, lane {k}, model over {what}, {name}: {} against {e}",
                        model.name(),
                        x.0[k]
                    );
                }
            }
        }
    }
}

// (1, 0), (0, 1), (−1, 0), (0, −1): the derivatives of the angle are (−y, x) / (x² + y²), also where x = 0.
#[test]
fn derivative_of_atan2_equals_closed_form_on_the_axes_and_between() {
    for (y, x) in [
        (0.0, 1.0),
        (1.0, 0.0),
        (0.0, -1.0),
        (-1.0, 0.0),
        (0.6, 0.8),
        (-2.0, -1.5),
        (3.0, -0.1),
    ] {
        let angle = Scalar::atan2(
            DualSVec64::<2>::from(y).derivative(0),
            DualSVec64::<2>::from(x).derivative(1),
        );
        let gradient = angle.eps.0.expect("a derivative");
        let r2: f64 = x * x + y * y;
        assert_eq!(angle.re, f64::atan2(y, x));
        assert!(
            (gradient[0] - x / r2).abs() < ROUNDING && (gradient[1] + y / r2).abs() < ROUNDING,
            "at ({x}, {y}): {gradient}"
        );
        let second = Scalar::atan2(HyperDual64::new(y, 1.0, 1.0, 0.0), x.into());
        assert!(
            (second.eps1eps2 + 2.0 * x * y / (r2 * r2)).abs() < 10.0 * ROUNDING,
            "at ({x}, {y}): {second}"
        );
    }
}

#[test]
fn selections_follow_the_value_and_carry_the_derivative_of_the_chosen_side() {
    let (x, y) = (Dual64::new(-2.0, 1.0), Dual64::new(3.0, 5.0));
    assert_eq!(Scalar::abs(x), Dual64::new(2.0, -1.0));
    assert_eq!(Scalar::min(x, y), x);
    assert_eq!(Scalar::max(x, y), y);
    assert_eq!(Scalar::clamp(y, -1.0, 1.0), Dual64::new(1.0, 0.0));
    assert_eq!(Scalar::abs(Dual64::new(0.0, 1.0)), Dual64::new(0.0, 1.0));
}

/// They wrap `f64`, over which the library contains the code of its functions.
#[test]
#[should_panic(expected = "is not supported, use")]
fn wrapped_numbers_without_derivatives_are_refused_by_name() {
    let [q, v, tau] = [0.1, 0.2, 0.3].map(|x| [Real::from_re(x)]);
    forward_dynamics(&samples::pendulum(), &q, &v, &tau);
}
