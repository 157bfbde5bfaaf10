//! Weights and systems at the boundary of what has a solution: which one is found, or the status that says why not.

use super::*;
use crate::tests::{ROUNDING, SAME_ALGEBRA};

// Without any cost on the state the cheapest stable loop mirrors the unstable modes: λ → 1/λ, or λ → −λ.
#[test]
fn unweighted_unstable_modes_equal_their_mirror_images() {
    let b = dmatrix![1.0; 1.0; 1.0];
    let problem = modal(&[2.0, -0.5, 1.25], &b, &DMatrix::zeros(3, 3));
    for (design, expected) in [
        (Lqr::discrete as Design, [0.8, 0.5, -0.5]),
        (Lqr::continuous as Design, [-0.5, -1.25, -2.0]),
    ] {
        let lqr = problem.solve(design);
        assert!(lqr.is_stabilized(), "{}", lqr.status);
        let mut found: Vec<_> = lqr.closed_loop_eigenvalues.iter().map(|z| z.re).collect();
        found.sort_by(|x, y| y.total_cmp(x));
        assert_relative_eq!(found.as_slice(), expected.as_slice(), max_relative = 1e-10);
    }
}

#[test]
fn unweighted_unstable_modes_of_unequal_inputs_equal_their_mirror_images() {
    for weak in [1e-2, 1e-4, 1e-6] {
        let (a, b) = (diagonal(&[2.0, 4.0]), diagonal(&[1.0, weak]));
        let lqr = Lqr::discrete(&a, &b, &DMatrix::zeros(2, 2), &DMatrix::identity(2, 2));
        assert!(lqr.is_stabilized(), "{weak}: {}", lqr.status);
        let moduli: Vec<_> = lqr
            .closed_loop_eigenvalues
            .iter()
            .map(|z| z.norm())
            .collect();
        assert_relative_eq!(
            moduli.as_slice(),
            [0.5, 0.25].as_slice(),
            max_relative = 1e-10
        );
    }
}

#[test]
fn partly_weighted_unstable_system_is_stabilized() {
    // The weight sees the first mode only.
    let problem = modal(
        &[1.1, 1.3, 0.5],
        &dmatrix![1.0; 1.0; 1.0],
        &diagonal(&[1.0, 0.0, 0.0]),
    );
    for (time, design) in BOTH_TIMES {
        let lqr = problem.solve(design);
        assert!(lqr.is_stabilized(), "{time:?}: {}", lqr.status);
        assert!(problem.textbook_residual(time, &lqr.cost_to_go) < RANDOM_RESIDUAL);
    }
}

// x⁺ = shift of x: dead-beat states, all eigenvalues zero. The input adds nothing but cost.
#[test]
fn shift_register_cost_equals_one_per_remaining_step() {
    let a = DMatrix::from_fn(5, 5, |i, j| if i == j + 1 { 1.0 } else { 0.0 });
    let b = DMatrix::from_fn(5, 1, |i, _| if i == 0 { 1.0 } else { 0.0 });
    let lqr = Lqr::discrete(&a, &b, &DMatrix::identity(5, 5), &dmatrix![1.0]);
    assert!(lqr.is_stabilized());
    assert_relative_eq!(
        lqr.cost_to_go,
        diagonal(&[5.0, 4.0, 3.0, 2.0, 1.0]),
        epsilon = 10.0 * ROUNDING
    );
    assert_eq!(lqr.gain.norm(), 0.0);
}

#[test]
fn unreachable_stable_mode_is_kept_by_the_loop() {
    let b = dmatrix![1.0; 0.0];
    let discrete = modal(&[1.5, 0.9], &b, &DMatrix::identity(2, 2)).solve(Lqr::discrete);
    assert!(discrete.is_stabilized());
    assert_relative_eq!(
        discrete.spectral_radius(),
        0.9,
        max_relative = OTHER_FORMULA
    );
    let continuous = modal(&[1.5, -0.1], &b, &DMatrix::identity(2, 2)).solve(Lqr::continuous);
    assert!(continuous.is_stabilized());
    assert_relative_eq!(
        continuous.spectral_abscissa(),
        -0.1,
        max_relative = OTHER_FORMULA
    );
}

#[test]
fn not_stabilizable_names_the_unreachable_eigenvalue() {
    let b = dmatrix![1.0; 0.0; 1.0];
    for (design, mode, others) in [
        (Lqr::discrete as Design, 1.2, [3.0, 0.5]),
        (Lqr::discrete as Design, 1.0, [3.0, 0.5]),
        (Lqr::discrete as Design, -1.0, [3.0, 0.5]),
        (Lqr::continuous as Design, 0.3, [1.0, -1.0]),
        (Lqr::continuous as Design, 0.0, [1.0, -1.0]),
    ] {
        let modes = [others[0], mode, others[1]];
        for q in [DMatrix::identity(3, 3), diagonal(&[1.0, 0.0, 1.0])] {
            let lqr = modal(&modes, &b, &q).solve(design);
            let LqrStatus::NotStabilizable { eigenvalue } = lqr.status else {
                panic!("mode {mode}: {}", lqr.status);
            };
            assert!(
                (eigenvalue - mode).norm() < 1e-10,
                "{eigenvalue} for {mode}"
            );
            assert!(lqr.gain.iter().all(|k| k.is_finite()) && !lqr.is_stabilized());
        }
    }
}

#[test]
fn not_stabilizable_names_an_unreachable_oscillation() {
    // A rotation by 0.7 that grows by a tenth per step, beside a reachable integrator.
    let (s, c) = 0.7_f64.sin_cos();
    let a = dmatrix![1.1 * c, -1.1 * s, 0.0; 1.1 * s, 1.1 * c, 0.0; 0.0, 0.0, 1.0];
    let b = dmatrix![0.0; 0.0; 1.0];
    let lqr = Lqr::discrete(&a, &b, &DMatrix::identity(3, 3), &dmatrix![1.0]);
    let LqrStatus::NotStabilizable { eigenvalue } = lqr.status else {
        panic!("{}", lqr.status);
    };
    assert!(
        (eigenvalue - Complex::from_polar(1.1, 0.7)).norm() < SAME_ALGEBRA,
        "{eigenvalue}"
    );
}

#[test]
fn unobserved_mode_names_the_boundary_eigenvalue() {
    let b = dmatrix![1.0; 1.0; 1.0];
    let q = diagonal(&[1.0, 0.0, 1.0]);
    for (design, modes) in [
        (Lqr::discrete as Design, [2.0, 1.0, 0.5]),
        (Lqr::discrete as Design, [0.9, -1.0, 0.5]),
        (Lqr::continuous as Design, [2.0, 0.0, -0.5]),
    ] {
        let lqr = modal(&modes, &b, &q).solve(design);
        let LqrStatus::UnobservedMode { eigenvalue } = lqr.status else {
            panic!(
                "{modes:?}: {} {:?}",
                lqr.status, lqr.closed_loop_eigenvalues
            );
        };
        assert!((eigenvalue - modes[1]).norm() < 1e-10, "{eigenvalue}");
    }
}

// The input reaches the mode that neither moves nor has a cost, and the cost does not see it.
#[test]
fn an_integrator_without_weight_is_unobserved() {
    let (zero, one) = (dmatrix![0.0], dmatrix![1.0]);
    for (design, mode) in [(Lqr::continuous as Design, &zero), (Lqr::discrete, &one)] {
        let lqr = design(mode, &one, &zero, &one);
        let is_unobserved = matches!(lqr.status, LqrStatus::UnobservedMode { .. });
        assert!(is_unobserved, "{}", lqr.status);
    }
}

#[test]
fn velocity_weight_alone_leaves_the_position_unobserved() {
    let (a, b) = (dmatrix![1.0, 0.1; 0.0, 1.0], dmatrix![0.005; 0.1]);
    let lqr = Lqr::discrete(&a, &b, &diagonal(&[0.0, 1.0]), &dmatrix![1.0]);
    assert!(
        matches!(lqr.status, LqrStatus::UnobservedMode { .. }),
        "{}",
        lqr.status
    );
    let lqr = Lqr::discrete(&a, &b, &diagonal(&[1.0, 0.0]), &dmatrix![1.0]);
    assert!(lqr.is_stabilized(), "{}", lqr.status);
}

#[test]
fn each_weight_defect_is_named() {
    let (a, b, one) = (
        DMatrix::identity(2, 2),
        DMatrix::identity(2, 2),
        DMatrix::identity(2, 2),
    );
    let skewed = dmatrix![1.0, 0.1; 0.0, 1.0];
    for (q, r, reason) in [
        (&skewed, &one, WeightDefect::StateNotSymmetric),
        (
            &diagonal(&[1.0, -1e-3]),
            &one,
            WeightDefect::StateIndefinite,
        ),
        (&one, &skewed, WeightDefect::InputNotSymmetric),
        (
            &one,
            &diagonal(&[1.0, 0.0]),
            WeightDefect::InputNotPositiveDefinite,
        ),
        (
            &one,
            &dmatrix![1.0, 1.0; 1.0, 1.0],
            WeightDefect::InputNotPositiveDefinite,
        ),
        (
            &one,
            &diagonal(&[1.0, -1.0]),
            WeightDefect::InputNotPositiveDefinite,
        ),
    ] {
        let lqr = Lqr::discrete(&a, &b, q, r);
        assert_eq!(lqr.status, LqrStatus::InvalidWeights { reason });
        assert_eq!((lqr.gain.shape(), lqr.residual), ((2, 2), f64::INFINITY));
    }
}

#[test]
fn not_a_number_or_infinity_in_any_argument_gives_not_finite() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for position in 0..4 {
            for (_, design) in BOTH_TIMES {
                let mut data = [0.5, 1.0, 1.0, 1.0];
                data[position] = bad;
                assert_eq!(scalar(design, data).status, LqrStatus::NotFinite);
            }
        }
    }
}

#[test]
fn overflowing_data_give_not_converged_and_finite_matrices() {
    for (_, design) in BOTH_TIMES {
        let lqr = scalar(design, [1e300; 4]);
        assert_eq!(lqr.status, LqrStatus::NotConverged);
        assert!(lqr.gain[0].is_finite() && lqr.cost_to_go[0].is_finite());
    }
}

#[test]
fn system_without_input_is_stabilized_exactly_if_it_is_stable() {
    let (b, r) = (DMatrix::zeros(1, 0), DMatrix::zeros(0, 0));
    let lqr = |a: f64| Lqr::discrete(&dmatrix![a], &b, &dmatrix![1.0], &r);
    // P = 1 / (1 − a²)
    assert_relative_eq!(
        lqr(0.5).cost_to_go[0],
        4.0 / 3.0,
        max_relative = 10.0 * ROUNDING
    );
    assert!(lqr(0.5).is_stabilized());
    assert!(matches!(lqr(1.5).status, LqrStatus::NotStabilizable { .. }));
}

#[test]
fn control_equals_minus_gain_times_state() {
    let lqr = scalar(Lqr::continuous, [1.0, 1.0, 3.0, 1.0]);
    assert_relative_eq!(
        lqr.control(&dvector![2.0])[0],
        -6.0,
        max_relative = 10.0 * ROUNDING
    );
}

#[test]
fn status_texts_name_the_cause() {
    let eigenvalue = Complex::new(1.5, 0.0);
    for (status, text) in [
        (LqrStatus::Stabilized, "stabilized"),
        (LqrStatus::NotStabilizable { eigenvalue }, "mode 1.5"),
        (LqrStatus::UnobservedMode { eigenvalue }, "mode 1.5"),
        (
            LqrStatus::InvalidWeights {
                reason: WeightDefect::StateIndefinite,
            },
            "Q is not positive semidefinite",
        ),
        (LqrStatus::NotFinite, "finite"),
        (LqrStatus::NotConverged, "not converged"),
    ] {
        assert!(status.to_string().contains(text), "{status}");
    }
}

#[test]
#[should_panic(expected = "Q is (1, 1), A is 2 x 2")]
fn weight_of_the_wrong_size_panics() {
    let two = DMatrix::identity(2, 2);
    Lqr::discrete(&two, &two, &dmatrix![1.0], &two);
}
