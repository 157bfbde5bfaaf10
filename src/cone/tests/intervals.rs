//! Rows with a bounded force: closed forms, other methods, bounds of zero and of infinity, recorded numbers.

use super::optimality::{OTHER_METHOD, assert_optimal, projected_iteration};
use super::*;
use crate::cone::{Smoothed, Status};
use crate::scalar::traced::{Graph, Port, trace};

const SAME_ALGEBRA: f64 = 1e-12;
/// Forces of recorded problems are those of a path near its end.
const NEAR_THE_END: f64 = 1e-6;

/// A mass that is pulled, held with a bounded force.
fn pulled(mass: f64, bound: f64, free_velocity: f64) -> Case {
    let matrix = DMatrix::from_element(1, 1, 1.0 / mass);
    let blocks = &[Block::Interval];
    Case::new(Law::Convex, blocks, bound, matrix, &[free_velocity])
}

#[test]
fn mass_is_held_up_to_the_bound_and_gives_way_beyond() {
    for (free_velocity, force, mode) in [
        (0.2, -0.4, Mode::Holding),
        (-0.2, 0.4, Mode::Holding),
        (0.9, -1.0, Mode::Yielding),
        (-0.9, 1.0, Mode::Yielding),
        (0.5, -1.0, Mode::Impending),
        (0.0, 0.0, Mode::Holding),
    ] {
        let case = pulled(2.0, 1.0, free_velocity);
        let solution = case.solve();
        assert_near("force", solution.f.as_slice(), &[force], SAME_ALGEBRA);
        assert_eq!(solution.modes, [mode], "{free_velocity}");
        assert!(solution.certificate.is_converged());
        let y = case.velocity(&solution.f)[0];
        assert!((y - (free_velocity + 0.5 * force)).abs() < SAME_ALGEBRA);
    }
}

#[test]
fn bound_of_zero_leaves_no_force_and_an_infinite_one_a_bilateral_row() {
    for law in LAWS {
        let mut case = Random(12.0).mixed_case(law, [1, 1, 1, 2], 12, 0.5);
        let last = case.blocks.len() - 1;
        case.friction[last] = 0.0;
        case.friction[last - 1] = f64::INFINITY;
        let solution = case.solve();
        assert!(solution.certificate.is_converged());
        assert_optimal("bounds", &case, &solution.f);
        assert_eq!(solution.f[6], 0.0);
        assert_eq!(solution.modes[last - 1], Mode::Bilateral);
        let mut other = case.clone();
        other.blocks[last - 1] = Block::Free(1);
        other.regularization[6] = f64::INFINITY;
        let expected = other.solve();
        assert_near(
            "forces",
            solution.f.as_slice(),
            expected.f.as_slice(),
            1e-10,
        );
        assert_eq!(expected.modes[last], Mode::Separated);
        case.friction[last] = f64::NAN;
        assert_eq!(case.solve().certificate.status, Status::NotFinite);
    }
}

#[test]
#[should_panic(expected = "is negative")]
fn negative_bound_panics() {
    pulled(1.0, -1.0, 0.0).solve();
}

#[test]
fn solutions_of_random_problems_satisfy_their_laws() {
    let shapes = [
        ([0, 0, 0, 6], 8, 0.0),
        ([2, 2, 2, 4], 20, 1.0),
        ([1, 1, 2, 3], 9, 1.0),
        ([0, 0, 0, 8], 5, 2.0),
    ];
    for law in LAWS {
        for (shape, (counts, dof, decades)) in shapes.into_iter().enumerate() {
            let mut random = Random(500.0 * shape as f64);
            for seed in 0..60 {
                let case = random.mixed_case(law, counts, dof, decades);
                let solution = case.solve();
                let name = format!("{law:?}, shape {shape}, seed {seed}");
                let certificate = solution.certificate;
                assert!(certificate.is_converged(), "{name}: {certificate:?}");
                assert!(certificate.residual < 1e-9 && certificate.cone_violation < 1e-12);
                assert!(
                    certificate.complementarity < 1e-8,
                    "{name}: {certificate:?}"
                );
                assert_optimal(&name, &case, &solution.f);
            }
        }
    }
}

#[test]
fn solutions_equal_those_of_very_many_projections() {
    for law in LAWS {
        let mut random = Random(6.0);
        for counts in [[0, 0, 0, 3], [1, 1, 1, 3]] {
            let rows = counts[0] + counts[1] + 3 * counts[2] + counts[3];
            let mut case = random.mixed_case(law, counts, rows, 0.0);
            case.regularization.fill(0.5);
            let (actual, expected) = (case.solve().f, projected_iteration(&case, 20_000));
            assert_near(
                "forces",
                actual.as_slice(),
                expected.as_slice(),
                OTHER_METHOD,
            );
        }
    }
}

/// The forces, by trying each row at its upper bound, at its lower one, and between: 3ⁿ linear problems.
fn enumerated(case: &Case) -> DVector<f64> {
    let n = case.free_velocity.len();
    let fits = |f: &DVector<f64>| {
        let y = case.velocity(f);
        (0..n).all(|i| {
            let bound = case.friction[i + 1];
            (f[i] - (f[i] - y[i]).clamp(-bound, bound)).abs() < 1e-9
        })
    };
    let found = (0..3_usize.pow(n as u32)).find_map(|choice| {
        let piece = |i: usize| choice / 3_usize.pow(i as u32) % 3;
        let bound = |i: usize| case.friction[i + 1] * (piece(i) as f64 - 1.0);
        let matrix = DMatrix::from_fn(n, n, |i, j| match piece(i) {
            1 => case.matrix[(i, j)] + if i == j { case.regularization[i] } else { 0.0 },
            _ => f64::from(i == j),
        });
        let right = DVector::from_fn(n, |i, _| match piece(i) {
            1 => -case.free_velocity[i],
            _ => bound(i),
        });
        matrix.lu().solve(&right).filter(fits)
    });
    found.expect("one of them holds")
}

#[test]
fn solutions_equal_those_of_all_active_sets() {
    let mut random = Random(31.0);
    for _ in 0..40 {
        let case = random.mixed_case(Law::Convex, [0, 0, 0, 5], 9, 0.5);
        let (actual, expected) = (case.solve().f, enumerated(&case));
        assert_near("forces", actual.as_slice(), expected.as_slice(), 1e-9);
    }
}

// The same row three times: bounds of 0.2, 0.3 and 5 carry 1 in sum; with 0.2, 0.3 and 0.1 all give way.
#[test]
fn redundant_rows_share_a_force_within_their_bounds() {
    let matrix = DMatrix::from_element(3, 3, 1.0);
    let mut case = Case::new(Law::Convex, &[Block::Interval; 3], 0.0, matrix, &[-1.0; 3]);
    case.friction = vec![0.2, 0.3, 5.0];
    let solution = case.solve();
    assert!(solution.certificate.is_converged());
    assert_near("sum", &[solution.f.sum()], &[1.0], 1e-9);
    assert!(solution.f[0] <= 0.2 + 1e-12 && solution.f[1] <= 0.3 + 1e-12);
    case.friction[2] = 0.1;
    let solution = case.solve();
    assert_near("forces", solution.f.as_slice(), &[0.2, 0.3, 0.1], 1e-12);
    assert_eq!(solution.modes, [Mode::Yielding; 3]);
}

// Bilateral rows that contradict each other have no solution; with bounded forces there is one.
#[test]
fn bounded_rows_that_contradict_each_other_pull_with_their_bounds() {
    let matrix = DMatrix::from_element(2, 2, 1.0);
    let case = Case::new(
        Law::Convex,
        &[Block::Interval; 2],
        3.0,
        matrix,
        &[-1.0, 1.0],
    );
    let solution = case.solve();
    assert!(solution.certificate.is_converged());
    assert_near("forces", solution.f.as_slice(), &[3.0, -3.0], 1e-12);
}

// G = 1:  (b² − f²) (f + g) + 2 κ f = 0.
#[test]
fn smoothed_force_satisfies_its_equation_and_tends_to_the_exact_one() {
    for free_velocity in [-2.0, -0.3, 0.0, 0.8] {
        let case = pulled(1.0, 0.5, free_velocity);
        let exact = case.solve().f[0];
        let mut last = f64::INFINITY;
        for kappa in [1e-2, 1e-4, 1e-6] {
            let solution = case.solve_smoothed(kappa);
            let f = solution.f[0];
            assert!(solution.certificate.is_converged() && f.abs() < 0.5);
            assert_eq!(solution.modes, [Mode::Smoothed]);
            let e = (0.25 - f * f) * (f + free_velocity) + 2.0 * kappa * f;
            assert!(e.abs() < 1e-11, "{e:e}");
            let error = (f - exact).abs();
            assert!(error <= last, "{free_velocity}, {kappa}: {error:e}");
            last = error;
        }
        assert!(last < 1e-4, "{free_velocity}: {last:e}");
    }
}

#[test]
fn intervals_keep_their_law_where_others_are_smoothed() {
    for law in LAWS {
        let mut random = Random(21.0);
        for smoothed in [Smoothed::Cones, Smoothed::RaysAndCones] {
            let case = random.mixed_case(law, [1, 1, 2, 3], 20, 0.5);
            let options = ConeOptions {
                smoothed,
                ..ConeOptions::default().with_smoothing(1e-3)
            };
            let mut solver = case.solver::<f64>(1e-3).with_options(options);
            let mut f = DVector::zeros(11);
            let certificate = solver.solve(&case.problem(), f.as_mut_slice());
            assert!(certificate.is_converged(), "{certificate:?}");
            let y = case.velocity(&f);
            for (row, block) in [(8, 4), (9, 5), (10, 6)] {
                let bound = case.friction[block];
                let off = f[row] - (f[row] - y[row]).clamp(-bound, bound);
                assert!(off.abs() < 1e-9, "{smoothed:?}: {off:e}");
                assert_ne!(solver.modes()[block], Mode::Smoothed);
            }
        }
    }
}

/// Records the forces of a problem over its numbers.
fn recorded(case: &Case) -> Graph {
    let (n, blocks) = (case.free_velocity.len(), case.blocks.len());
    trace(|t| {
        let matrix = t.input(Port::matrix("G", n, n));
        let regularization = t.input(Port::vector("R", n));
        let free_velocity = t.input(Port::vector("g", n));
        let friction = t.input(Port::vector("mu", blocks));
        let problem = ConeProblem {
            law: Law::Convex,
            blocks: &case.blocks,
            friction: &friction,
            matrix: &matrix,
            regularization: &regularization,
            free_velocity: &free_velocity,
        };
        let mut f = vec![matrix[0] * 0.0; n];
        ConeSolver::new(n, blocks).solve(&problem, &mut f);
        t.output(Port::vector("f", n), &f);
    })
}

#[test]
fn recorded_forces_equal_those_of_the_active_set() {
    for counts in [[0, 0, 0, 4], [1, 1, 1, 3]] {
        let mut random = Random(44.0);
        let first = random.mixed_case(Law::Convex, counts, 14, 0.5);
        let (graph, last) = (recorded(&first), first.blocks.len() - 1);
        for seed in 0..60 {
            let mut case = random.mixed_case(Law::Convex, counts, 14, 0.5);
            case.regularization.fill(0.01);
            match seed % 4 {
                0 => case.friction[last] = 0.0,
                1 => case.friction[last] = f64::INFINITY,
                2 => case.friction[last] *= 1e-4,
                _ => *case.regularization.last_mut().expect("a row") = f64::INFINITY,
            }
            let given = [
                case.matrix.as_slice(),
                &case.regularization,
                case.free_velocity.as_slice(),
                &case.friction,
            ];
            let found = graph.evaluate(&given.concat()).expect("forces are found");
            let exact = case.solve().f;
            assert_near("forces", &found, exact.as_slice(), NEAR_THE_END);
        }
    }
}
