//! The central path: closed forms, its end, and the use of its derivatives.

use super::*;
use crate::cone::Smoothed;
use num_dual::Dual64;

fn particle(law: Law, normal_velocity: f64, slip: f64) -> Case {
    Case::new(
        law,
        &[Block::Cone],
        0.5,
        DMatrix::identity(3, 3),
        &[normal_velocity, slip, 0.0],
    )
}

// G = 1, no slip:  f (f + g) = κ,  f = (√(g² + 4 κ) − g) / 2.
#[test]
fn smoothed_normal_force_equals_its_closed_form() {
    let kappa = 1e-3;
    for law in LAWS {
        for g in [-1.0_f64, 0.0, 2.0] {
            let expected = 0.5 * ((g * g + 4.0 * kappa).sqrt() - g);
            let solution = particle(law, g, 0.0).solve_smoothed(kappa);
            assert_near("force", solution.f.as_slice(), &[expected, 0.0, 0.0], 1e-9);
            assert_eq!(solution.modes, [Mode::Smoothed]);
        }
    }
    let ray = Case::new(
        Law::Convex,
        &[Block::Ray],
        0.0,
        DMatrix::identity(1, 1),
        &[0.3],
    );
    let expected = 0.5 * ((0.09 + 4.0 * kappa).sqrt() - 0.3);
    assert_near(
        "ray",
        ray.solve_smoothed(kappa).f.as_slice(),
        &[expected],
        1e-11,
    );
}

// Both laws give  (μ² fₙ² − ‖fₜ‖²) yₜ = −κ fₜ; they differ in the normal row.
#[test]
fn smoothed_forces_satisfy_the_equations_of_their_law() {
    let kappa = 1e-2;
    for law in LAWS {
        let mut random = Random(60.0);
        for _ in 0..20 {
            let mut case = random.case(law, [0, 0, 3], 14, 1.0);
            case.regularization.fill(0.1);
            let solution = case.solve_smoothed(kappa);
            assert!(solution.certificate.is_converged());
            let (f, y) = (&solution.f, case.velocity(&solution.f));
            for cone in 0..3 {
                let (n, mu) = (3 * cone, case.friction[1 + cone]);
                let tangential = f[n + 1] * y[n + 1] + f[n + 2] * y[n + 2];
                let product = f[n] * y[n] + if law == Law::Convex { tangential } else { 0.0 };
                assert_near("product", &[product], &[kappa], 1e-8);
                let inside = mu * mu * f[n] * f[n] - f[n + 1].powi(2) - f[n + 2].powi(2);
                assert!(inside > 0.0 && f[n] > 0.0 && y[n] > 0.0);
                for i in [n + 1, n + 2] {
                    assert_near("tangent", &[inside * y[i]], &[-kappa * f[i]], 1e-8);
                }
            }
        }
    }
}

#[test]
fn smoothed_forces_tend_to_the_exact_ones() {
    for law in LAWS {
        let mut random = Random(70.0);
        for _ in 0..10 {
            let case = random.case(law, [1, 1, 3], 20, 0.0);
            let exact = case.solve().f;
            let error = |kappa: f64| (case.solve_smoothed(kappa).f - &exact).norm() / exact.norm();
            let errors = [error(1e-3), error(1e-5), error(1e-7), error(1e-9)];
            assert!(
                errors[3] < 1e-3 && errors[3] < errors[0],
                "{law:?}: {errors:?}"
            );
        }
    }
}

#[test]
fn smoothed_derivatives_are_there_before_touch_down_and_while_sticking() {
    for law in LAWS {
        let slope = |case: &Case, row: usize, kappa: f64| {
            let free_velocity: Vec<Dual64> = (0..3)
                .map(|i| Dual64::new(case.free_velocity[i], f64::from(i == row)))
                .collect();
            let lift = |x: &[f64]| x.iter().map(|&x| Dual64::from_re(x)).collect::<Vec<_>>();
            let problem = ConeProblem {
                law,
                blocks: &case.blocks,
                friction: &lift(&case.friction),
                matrix: &lift(case.matrix.as_slice()),
                regularization: &lift(&case.regularization),
                free_velocity: &free_velocity,
            };
            let mut f = lift(&[0.0; 3]);
            assert!(case.solver(kappa).solve(&problem, &mut f).is_converged());
            f.iter().map(|f| f.eps).collect::<Vec<_>>()
        };
        let above = particle(law, 0.5, 0.2);
        assert_eq!(slope(&above, 0, 0.0), [0.0; 3]);
        assert!(slope(&above, 0, 1e-2)[0] < -1e-3);
        // Sliding, the exact friction does not feel the slip; the smoothed one does.
        let sliding = particle(Law::Coulomb, -0.1, 0.5);
        assert!(slope(&sliding, 1, 1e-2)[1] < -1e-4);
    }
}

// The path's equations have other solutions outside the cones; none of them is taken, wherever the search starts.
#[test]
fn smoothed_forces_do_not_depend_on_the_start() {
    for law in LAWS {
        let mut random = Random(80.0);
        for _ in 0..20 {
            let case = random.case(law, [0, 0, 2], 9, 0.0);
            let expected = case.solve_smoothed(1e-2).f;
            for _ in 0..10 {
                let mut f = random.vector(6) * 3.0;
                (f[0], f[3]) = (f[0].abs(), f[3].abs());
                let certificate = case.solver(1e-2).solve(&case.problem(), f.as_mut_slice());
                assert!(certificate.is_converged());
                assert_near("forces", f.as_slice(), expected.as_slice(), 1e-7);
            }
        }
    }
}

// Two walls that close on a body: there is no velocity that leaves both, and so no smoothed force without some regularisation.
#[test]
fn squeezed_body_needs_regularisation_for_smoothed_forces() {
    let matrix = DMatrix::from_row_slice(2, 2, &[1.0, -1.0, -1.0, 1.0]);
    let mut case = Case::new(Law::Convex, &[Block::Ray; 2], 0.0, matrix, &[0.0, 0.0]);
    assert!(!case.solve_smoothed(1e-3).certificate.is_converged());
    case.regularization.fill(0.1);
    // Both forces are √(κ / R).
    let solution = case.solve_smoothed(1e-3);
    assert!(solution.certificate.is_converged());
    assert_near("forces", solution.f.as_slice(), &[0.1; 2], 1e-9);
}

// Exact rays and smoothed cones in one problem: f y = 0 for the one, = κ for the other.
#[test]
fn rays_keep_their_law_where_only_cones_are_smoothed() {
    let kappa = 1e-3;
    for law in LAWS {
        let mut random = Random(90.0);
        for _ in 0..30 {
            let case = random.case(law, [1, 3, 2], 16, 0.5);
            let options = ConeOptions {
                smoothed: Smoothed::Cones,
                ..ConeOptions::default().with_smoothing(kappa)
            };
            let mut solver = case.solver::<f64>(kappa).with_options(options);
            let mut f = DVector::zeros(10);
            let certificate = solver.solve(&case.problem(), f.as_mut_slice());
            assert!(certificate.is_converged(), "{certificate:?}");
            let y = case.velocity(&f);
            for ray in 1..4 {
                assert!(f[ray] >= 0.0 && y[ray] >= -1e-9, "{f} {y}");
                assert_near("ray", &[f[ray] * y[ray]], &[0.0], 1e-9);
                assert_ne!(solver.modes()[ray], Mode::Smoothed);
            }
            for cone in [4, 7] {
                let tangential = f[cone + 1] * y[cone + 1] + f[cone + 2] * y[cone + 2];
                let extra = if law == Law::Convex { tangential } else { 0.0 };
                assert_near("cone", &[f[cone] * y[cone] + extra], &[kappa], 1e-8);
            }
        }
    }
}

// A block that gives way without a force has none on the path either.
#[test]
fn smoothed_forces_are_those_without_what_gives_way() {
    for law in LAWS {
        let mut random = Random(95.0);
        let case = random.case(law, [0, 1, 2], 12, 0.5);
        let mut with = case.clone();
        with.regularization[0] = f64::INFINITY;
        with.regularization[4..].fill(f64::INFINITY);
        let all = with.solve_smoothed(1e-2);
        assert!(all.certificate.is_converged());
        assert_eq!((all.f[0], all.f.rows(4, 3).amax()), (0.0, 0.0));
        assert_eq!(all.modes[1], Mode::Separated);
        assert_eq!(all.modes[3], Mode::Separated);
        let one = Case {
            law,
            blocks: vec![Block::Cone],
            friction: vec![case.friction[2]],
            matrix: case.matrix.view((1, 1), (3, 3)).into(),
            regularization: vec![0.0; 3],
            free_velocity: case.free_velocity.rows(1, 3).into(),
        };
        let alone = one.solve_smoothed(1e-2).f;
        assert_near("force", &all.f.as_slice()[1..4], alone.as_slice(), 1e-9);
    }
}
