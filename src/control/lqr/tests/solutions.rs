//! Solutions against closed forms, the equation itself, what a loop costs, and another program.

use super::*;
use crate::tests::{OTHER_ALGORITHM, ROUNDING};

// With x⁺ = a x + b u: b² P² + (r − a² r − b² q) P − q r = 0.
#[test]
fn scalar_dare_equals_closed_form() {
    for [a, b, q, r] in [
        [1.0, 1.0, 1.0, 1.0],
        [1.5, 0.1, 2.0, 3.0],
        [-0.7, 2.0, 0.3, 1e-3],
        [0.0, 1.0, 5.0, 1.0],
        [20.0, 1e-3, 1.0, 1.0],
    ] {
        let half = 0.5 * (r - a * a * r - b * b * q);
        let p = (f64::hypot(half, (b * b * q * r).sqrt()) - half) / (b * b);
        let lqr = scalar(Lqr::discrete, [a, b, q, r]);
        assert!(lqr.is_stabilized());
        assert_relative_eq!(lqr.cost_to_go[0], p, max_relative = OTHER_FORMULA);
        let gain = a * b * p / (r + b * b * p);
        assert_relative_eq!(lqr.gain[0], gain, max_relative = OTHER_FORMULA);
    }
}

// With ẋ = a x + b u: P = (a + √(a² + b² q / r)) r / b², and the loop is ẋ = −√(a² + b² q / r) x.
#[test]
fn scalar_care_equals_closed_form() {
    for [a, b, q, r] in [
        [1.0, 1.0, 1.0, 1.0],
        [1.5, 0.1, 2.0, 3.0],
        [-0.7, 2.0, 30.0, 1e-3],
        [0.0, 1.0, 5.0, 1.0],
        [2e4, 1e-3, 1.0, 1.0],
    ] {
        let pole = f64::hypot(a, (b * b * q / r).sqrt());
        let lqr = scalar(Lqr::continuous, [a, b, q, r]);
        assert!(lqr.is_stabilized());
        let p = (a + pole) * r / (b * b);
        assert_relative_eq!(lqr.cost_to_go[0], p, max_relative = OTHER_FORMULA);
        assert_relative_eq!(lqr.spectral_abscissa(), -pole, max_relative = OTHER_FORMULA);
    }
}

// K = [1, √3], P = [√3, 1; 1, √3], poles (−√3 ± i) / 2.
#[test]
fn double_integrator_equals_closed_form() {
    let (a, b) = (dmatrix![0.0, 1.0; 0.0, 0.0], dmatrix![0.0; 1.0]);
    let lqr = Lqr::continuous(&a, &b, &DMatrix::identity(2, 2), &dmatrix![1.0]);
    let root = 3.0_f64.sqrt();
    assert_relative_eq!(lqr.gain, dmatrix![1.0, root], epsilon = 10.0 * ROUNDING);
    assert_relative_eq!(
        lqr.cost_to_go,
        dmatrix![root, 1.0; 1.0, root],
        epsilon = 10.0 * ROUNDING
    );
    let pole = lqr.closed_loop_eigenvalues[0];
    assert_relative_eq!(pole.re, -0.5 * root, epsilon = 10.0 * ROUNDING);
    assert_relative_eq!(pole.im, 0.5, epsilon = 10.0 * ROUNDING);
}

// The loop is the Butterworth filter s² + √2 ω s + ω² with ω = r^(−1/4), so K = [ω², √2 ω].
#[test]
fn position_weighted_double_integrator_equals_closed_form() {
    let (a, b) = (dmatrix![0.0, 1.0; 0.0, 0.0], dmatrix![0.0; 1.0]);
    for r in [1e-8, 1.0, 1e8] {
        let lqr = Lqr::continuous(&a, &b, &diagonal(&[1.0, 0.0]), &dmatrix![r]);
        let expected = dmatrix![r.powf(-0.5), 2.0_f64.sqrt() * r.powf(-0.25)];
        assert!(lqr.is_stabilized());
        assert_relative_eq!(lqr.gain[0], expected[0], max_relative = OTHER_FORMULA);
        assert_relative_eq!(lqr.gain[1], expected[1], max_relative = OTHER_FORMULA);
    }
}

fn check_solution(problem: &Problem) {
    for (time, design) in BOTH_TIMES {
        let lqr = problem.solve(design);
        let nx = problem.a.nrows();
        assert!(
            lqr.is_stabilized(),
            "{time:?} nx {nx}: {} {problem:?}",
            lqr.status
        );
        let residual = problem.textbook_residual(time, &lqr.cost_to_go);
        assert!(
            residual < RANDOM_RESIDUAL,
            "{time:?} nx {nx}: residual {residual:e}"
        );
        assert!(
            lqr.residual < RANDOM_RESIDUAL,
            "{time:?} nx {nx}: {:e}",
            lqr.residual
        );
        assert_eq!(lqr.cost_to_go, lqr.cost_to_go.transpose());
        match time {
            TimeDomain::Discrete => assert!(lqr.spectral_radius() < 1.0),
            TimeDomain::Continuous => assert!(lqr.spectral_abscissa() < 0.0),
        }
    }
}

proptest! {
    #![proptest_config(fixed_seed(40))]

    #[test]
    fn riccati_residual_vanishes_and_the_loop_is_stable(
        problem in (1..12_usize).prop_flat_map(|nx| problems(nx, 1 + nx / 3))
    ) {
        check_solution(&problem);
    }

    #[test]
    fn cost_to_go_equals_the_summed_cost_of_the_loop(problem in problems(5, 2)) {
        let lqr = problem.solve(Lqr::discrete);
        let summed = problem.cost_of(&lqr.gain);
        prop_assert!((&summed - &lqr.cost_to_go).norm() <= OTHER_ALGORITHM * summed.norm());
    }

    #[test]
    fn perturbed_gain_costs_at_least_as_much(problem in problems(4, 2), change in entries(2, 4)) {
        let lqr = problem.solve(Lqr::discrete);
        // Small enough for the perturbed loop to be stable.
        let step = 0.1 * (1.0 - lqr.spectral_radius()) / (1.0 + problem.b.norm());
        let perturbed = problem.cost_of(&(&lqr.gain + change * step));
        let excess = (perturbed - &lqr.cost_to_go).symmetric_eigenvalues();
        prop_assert!(excess.min() >= -1e-9 * lqr.cost_to_go.norm(), "{}", excess);
    }
}

#[test]
fn riccati_residual_vanishes_for_large_systems() {
    for (nx, nu) in [(30, 4), (70, 8)] {
        check_solution(&one_problem(nx, nu));
    }
}

#[test]
fn cost_to_go_equals_the_simulated_cost() {
    let problem = one_problem(6, 2);
    let lqr = problem.solve(Lqr::discrete);
    let start = DVector::from_fn(6, |i, _| 1.0 - 0.3 * i as f64);
    let (mut x, mut cost) = (start.clone(), 0.0);
    for _ in 0..5000 {
        let u = lqr.control(&x);
        cost += x.dot(&(&problem.q * &x)) + u.dot(&(&problem.r * &u));
        x = &problem.a * x + &problem.b * u;
    }
    let expected = start.dot(&(&lqr.cost_to_go * &start));
    assert_relative_eq!(cost, expected, max_relative = 1e-10);
}

// x⁺ = (I + A dt) x + B dt u at the cost dt (xᵀQx + uᵀRu): the error of the gain is O(dt).
#[test]
fn continuous_gain_equals_the_limit_of_the_discrete_gain() {
    let Problem { a, b, q, r } = one_problem(4, 2);
    let limit = Lqr::continuous(&a, &b, &q, &r).gain;
    let error = |dt: f64| {
        let step = DMatrix::identity(4, 4) + &a * dt;
        let gain = Lqr::discrete(&step, &(&b * dt), &(&q * dt), &(&r * dt)).gain;
        (gain - &limit).norm()
    };
    assert!(error(1e-6) < 1e-4 * limit.norm());
    assert_relative_eq!(error(1e-4) / error(5e-5), 2.0, max_relative = 0.02);
}

// A cart with a pole, linearised upright, one Euler step of dt: ẍ = u, θ̈ = g θ + u (in suitable units).
#[test]
fn badly_scaled_cart_pole_equals_the_same_in_other_units() {
    let dt = 1e-3;
    let a = DMatrix::identity(4, 4)
        + dmatrix![
            0.0, 0.0, 1.0, 0.0;
            0.0, 0.0, 0.0, 1.0;
            0.0, 0.98, 0.0, 0.0;
            0.0, 21.6, 0.0, 0.0
        ] * dt;
    let b = dmatrix![0.0; 0.0; 1.0; 2.0] * dt;
    let q = diagonal(&[1.0, 1000.0, 1.0, 10.0]);
    let units = diagonal(&[1e-6, 1e3, 1e5, 1e-4]);
    let inverse = units.clone().try_inverse().unwrap();
    let r = dmatrix![1e-3];
    let lqr = Lqr::discrete(&a, &b, &q, &r);
    let scaled = Lqr::discrete(
        &(&inverse * &a * &units),
        &(&inverse * &b),
        &(&units * &q * &units),
        &r,
    );
    assert!(lqr.is_stabilized() && scaled.is_stabilized());
    assert!(lqr.residual < 10.0 * ROUNDING && scaled.residual < 10.0 * ROUNDING);
    assert_relative_eq!(
        scaled.gain * inverse,
        lqr.gain,
        max_relative = OTHER_ALGORITHM
    );
}

// Golden numbers: scipy 1.17.1 `solve_continuous_are` and `solve_discrete_are` for this system with R = 10⁻³; the
// first gain of the continuous regulator is −√(q₁ / r) exactly.
#[test]
fn cart_pole_gains_equal_those_of_scipy() {
    let a = dmatrix![
        0.0, 0.0, 1.0, 0.0;
        0.0, 0.0, 0.0, 1.0;
        0.0, 0.981, 0.0, 0.0;
        0.0, 21.58, 0.0, 0.0
    ];
    let (b, dt) = (dmatrix![0.0; 0.0; 1.0; 2.0], 1e-3);
    let (q, r) = (diagonal(&[1.0, 1000.0, 1.0, 10.0]), dmatrix![1e-3]);
    let continuous = Lqr::continuous(&a, &b, &q, &r).gain;
    let discrete = Lqr::discrete(&(DMatrix::identity(4, 4) + &a * dt), &(&b * dt), &q, &r).gain;
    let expected = [
        [
            -31.6227766016839,
            1121.46461699713,
            -90.3399355977239,
            151.732875176127,
        ],
        [
            -28.4314603555294,
            1010.59372267868,
            -81.2806010081176,
            137.459844587971,
        ],
    ];
    assert_relative_eq!(continuous[0], -1000.0_f64.sqrt(), max_relative = 1e-13);
    for (gain, golden) in [continuous, discrete].iter().zip(expected) {
        assert_relative_eq!(gain.as_slice(), golden.as_slice(), max_relative = 1e-10);
    }
}
