//! Gradient, limits and refusals of exciting motions.

use super::*;
use crate::identify::DryFriction;
use crate::minimize::Objective;
use crate::model::samples;

fn regressor() -> Regressor {
    Regressor::new(&samples::cartpole())
        .with_damping()
        .with_dry_friction(DryFriction::Smooth {
            slip_velocity: 0.05,
        })
        .unwrap()
}

#[test]
fn gradient_of_the_condition_equals_differences() {
    let options = ExcitationOptions {
        harmonics: 3,
        ..Default::default()
    };
    let regressor = regressor();
    let problem = Problem::new(&regressor, &options).unwrap();
    let x: Vec<f64> = (0..problem.n_variables())
        .map(|k| (1.0 + 1.7 * k as f64).sin())
        .collect();
    let gradient = problem.gradient(&x);
    for k in 0..x.len() {
        const STEP: f64 = 1e-5;
        let at = |by: f64| {
            let mut moved = x.clone();
            moved[k] += by;
            problem.value(&moved)
        };
        let difference = (at(STEP) - at(-STEP)) / (2.0 * STEP);
        assert!(
            (gradient[k] - difference).abs() < 1e-7,
            "{k}: {} {difference}",
            gradient[k]
        );
    }
}

#[test]
fn motion_keeps_the_limits_at_all_times_and_lowers_the_condition() {
    let options = ExcitationOptions {
        starts: 1,
        max_iterations: 25,
        ..Default::default()
    };
    let model = samples::cartpole();
    let found = excite(&regressor(), &options).unwrap();
    assert!(
        found.condition < 0.8 * found.start_condition,
        "{} {}",
        found.condition,
        found.start_condition
    );
    let limits = model.limits(model.joint("linear").unwrap());
    for k in 0..5000 {
        let at = found.at(found.period * f64::from(k) / 5000.0);
        assert!(at.q[0] < limits.upper.unwrap() && at.q[0] > limits.lower.unwrap());
        assert!(at.q[1].abs() <= options.reach);
        assert!(at.v[0].abs() <= limits.velocity.unwrap() && at.v[1].abs() <= options.speed);
        assert!(at.a.amax() <= options.acceleration);
    }
    // Periodic, and a derivative is one.
    let step = 1e-6;
    let rate = (found.at(3.0 + step).q - found.at(3.0 - step).q) / (2.0 * step);
    assert!((rate - found.at(3.0).v).amax() < 1e-8);
    assert!((found.at(1.0).q - found.at(1.0 + found.period).q).amax() < 1e-12);
}

#[test]
fn options_and_joints_of_no_use_are_refused_by_name() {
    let says = |regressor: &Regressor, options: ExcitationOptions, expected: &str| {
        let text = excite(regressor, &options).unwrap_err().to_string();
        assert!(text.contains(expected), "{text}\ndoes not say: {expected}");
    };
    let own = regressor();
    says(
        &own,
        ExcitationOptions {
            period: 0.0,
            ..Default::default()
        },
        "period: 0",
    );
    says(
        &own,
        ExcitationOptions {
            force_deviations: vec![1.0],
            ..Default::default()
        },
        "force deviations of 1 numbers",
    );
    says(
        &own,
        ExcitationOptions {
            harmonics: 100_000_000,
            ..Default::default()
        },
        "harmonics: Fourier series of 100000000 harmonics need",
    );
    let tree = Regressor::new(&samples::random_tree(6, 1));
    says(&tree, ExcitationOptions::default(), "not those of a line");
}

#[test]
fn motions_without_a_period_are_refused() {
    for period in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let motion = Excitation {
            period,
            center: vec![0.0],
            coefficients: DMatrix::zeros(1, 2),
            condition: 1.0,
            start_condition: 1.0,
        };
        let panic = std::panic::catch_unwind(|| motion.at(0.5)).expect_err("a panic");
        let text = panic.downcast_ref::<String>().expect("a text");
        assert!(text.contains("must be positive and finite"), "{text}");
    }
}
