//! Invalid numbers, and problems without solution.

use super::*;
use crate::cone::{REGULARIZATION, Status};
use num_dual::Dual64;

#[test]
fn numbers_that_are_not_finite_are_a_status_and_forces_are_zero() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for place in 0..4 {
            let mut case = Random(1.0).case(Law::Coulomb, [1, 1, 2], 20, 0.0);
            let mut f = vec![1.0; 8];
            match place {
                0 => case.matrix[(3, 4)] = bad,
                1 => case.free_velocity[2] = bad,
                // An infinite one means that the block takes no part.
                2 if bad == f64::INFINITY => continue,
                2 => case.regularization[0] = bad,
                _ => f[1] = bad,
            }
            let certificate = case.solver(0.0).solve(&case.problem(), &mut f);
            assert_eq!(
                (certificate.status, &f[..]),
                (Status::NotFinite, &[0.0; 8][..])
            );
        }
        let mut case = Random(1.0).case(Law::Coulomb, [0, 0, 1], 3, 0.0);
        case.friction.fill(bad.abs());
        assert_eq!(case.solve().certificate.status, Status::NotFinite);
    }
}

#[test]
fn derivatives_of_what_is_not_finite_are_zero() {
    let lift = |x: &[f64]| x.iter().map(|&x| Dual64::new(x, 1.0)).collect::<Vec<_>>();
    let problem = ConeProblem {
        law: Law::Convex,
        blocks: &[Block::Free(1), Block::Ray],
        friction: &lift(&[0.0; 2]),
        matrix: &lift(&[1.0, 0.0, 0.0, f64::NAN]),
        regularization: &lift(&[0.0; 2]),
        free_velocity: &lift(&[1.0; 2]),
    };
    let mut f = lift(&[0.0; 2]);
    let certificate = ConeSolver::new(2, 2).solve(&problem, &mut f);
    assert_eq!(certificate.status, Status::NotFinite);
    assert!(f.iter().all(|f| f.re == 0.0 && f.eps == 0.0), "{f:?}");
}

// y₁ = f₁ + f₂ − 1 and y₂ = f₁ + f₂ + 1 cannot both vanish: least squares, and forces that the regularization bounds.
#[test]
fn bilateral_rows_that_contradict_each_other_share_the_contradiction() {
    let matrix = DMatrix::from_element(2, 2, 1.0);
    let case = Case::new(Law::Convex, &[Block::Free(2)], 0.0, matrix, &[-1.0, 1.0]);
    let solution = case.solve();
    assert_eq!(solution.certificate.status, Status::Regularized);
    assert_near(
        "velocities",
        case.velocity(&solution.f).as_slice(),
        &[-1.0, 1.0],
        1e-9,
    );
    assert_near(
        "forces",
        solution.f.as_slice(),
        &[1.0 / REGULARIZATION, -1.0 / REGULARIZATION],
        1e-6,
    );
    assert!(solution.certificate.dual_violation > 1e-6);
}

#[test]
fn contact_with_what_cannot_move_is_a_status() {
    for law in LAWS {
        let case = Case::new(
            law,
            &[Block::Cone],
            0.5,
            DMatrix::zeros(3, 3),
            &[-1.0, 0.3, 0.0],
        );
        let solution = case.solve();
        assert!(!solution.certificate.is_converged());
        assert!(solution.f.iter().all(|f| f.is_finite()) && solution.f[0] >= 0.0);
    }
}

// Finite input of any size gives finite results.
#[test]
fn finite_problems_of_any_size_have_finite_forces() {
    let sizes = [1e-300, 1e-160, 1e-20, 1.0, 1e20, 1e150, 1e300];
    for law in LAWS {
        for kappa in [0.0, 1e-3] {
            for (size, other) in sizes.iter().flat_map(|a| sizes.map(|b| (*a, b))) {
                let mut case = Random(2.0).case(law, [1, 1, 2], 6, 0.0);
                case.matrix *= size;
                case.free_velocity *= other;
                let solution = case.solve_smoothed(kappa);
                let finite = solution.f.iter().all(|f| f.is_finite());
                assert!(
                    finite,
                    "{law:?} κ {kappa}, {size:e}, {other:e}: {}",
                    solution.f
                );
                let status = solution.certificate.status;
                let moderate = |x: f64| (1e-20..=1e20).contains(&x);
                if kappa == 0.0 && moderate(size) && moderate(other) {
                    assert_eq!(status, Status::Converged, "{law:?} {size:e}, {other:e}");
                }
            }
        }
    }
}

#[test]
fn nothing_to_solve_is_solved() {
    let empty = Case::new(Law::Convex, &[], 0.0, DMatrix::zeros(0, 0), &[]);
    assert!(empty.solve().certificate.is_converged());
    let no_rows = Case::new(
        Law::Convex,
        &[Block::Free(0)],
        0.0,
        DMatrix::zeros(0, 0),
        &[],
    );
    assert_eq!(no_rows.solve().modes, [Mode::Bilateral]);
    for law in LAWS {
        let at_rest = Case::new(law, &[Block::Cone], 0.5, DMatrix::zeros(3, 3), &[0.0; 3]);
        assert!(at_rest.solve().certificate.is_converged());
    }
}

#[test]
#[should_panic(expected = "is negative")]
fn negative_friction_panics() {
    Case::new(
        Law::Convex,
        &[Block::Cone],
        -0.1,
        DMatrix::identity(3, 3),
        &[0.0; 3],
    )
    .solve();
}

#[test]
#[should_panic(expected = "the blocks have 1 rows, the free velocity 3")]
fn wrong_length_panics() {
    Case::new(
        Law::Convex,
        &[Block::Ray],
        0.1,
        DMatrix::identity(3, 3),
        &[0.0; 3],
    )
    .solve();
}
