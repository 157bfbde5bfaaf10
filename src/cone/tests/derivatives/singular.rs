//! Derivatives where modes meet, and where there is no solution.

use super::*;
use crate::cone::REGULARIZATION;

// Between modes the derivative is that of one side.
#[test]
fn derivatives_at_singular_points_are_finite_and_those_of_one_side() {
    let points = [
        [0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [-1.0, 0.4, 0.0],
        [-1.0, 0.0, 0.0],
        [-1e-2, 0.0, 0.0],
        [0.4, -1.0, 0.0],
    ];
    for law in LAWS {
        for point in points {
            let case = Case::new(law, &[Block::Cone], 0.4, DMatrix::identity(3, 3), &point);
            let f = case.solve().f;
            for index in [0, 4, 9, 12, 13, 14, 15] {
                let actual = case.derivative(index, f.as_slice(), 0.0);
                let one_side = |by: f64| (case.moved(index, by, f.as_slice(), 0.0) - &f) / by;
                let near = |side: DVector<f64>| (0..3).all(|i| (actual[i] - side[i]).abs() < 1e-4);
                // At the tip of the cone the derivative is that of separation, for both signs of the parameter.
                let separated = f.amax() == 0.0 && actual == [0.0; 3];
                let right = separated || near(one_side(STEP)) || near(one_side(-STEP));
                assert!(right, "{law:?} at {point:?}, parameter {index}: {actual:?}");
            }
        }
    }
}

#[test]
fn derivatives_next_to_singular_points_are_finite() {
    for law in LAWS {
        for tiny in [1e-300, 1e-200, 1e-120, 1e-50, 1e-17] {
            for [n, t] in [
                [-1.0, tiny],
                [-tiny, tiny],
                [-tiny, -1.0],
                [tiny, tiny],
                [-1.0, 0.4 + tiny],
            ] {
                for mu in [0.4, 0.0, tiny] {
                    let identity = DMatrix::identity(3, 3);
                    let case = Case::new(law, &[Block::Cone], mu, identity, &[n, t, 0.0]);
                    let f = case.solve().f;
                    for index in [0, 4, 9, 12, 13, 14, 15] {
                        let actual = case.derivative(index, f.as_slice(), 0.0);
                        let finite = actual.iter().all(|x| x.is_finite());
                        assert!(finite, "{law:?} at ({n:e}, {t:e}), μ {mu:e}: {actual:?}");
                    }
                }
            }
        }
    }
}

// Without a solution the forces are those of the regularised problem, and so are their derivatives: with S = (G + R + ε)⁻¹,
// ∂f/∂g = −S  and  ∂²f/∂g₁∂R₁ = S₁₁ S e₁.
#[test]
fn derivatives_of_regularized_forces_are_those_of_the_regularized_problem() {
    let number = |re: f64, eps1: f64, eps2: f64| HyperDual64::new(re, eps1, eps2, 0.0);
    let problem = ConeProblem {
        law: Law::Convex,
        blocks: &[Block::Free(2)],
        friction: &[number(0.0, 0.0, 0.0)],
        matrix: &[number(1.0, 0.0, 0.0); 4],
        regularization: &[number(0.0, 0.0, 1.0), number(0.0, 0.0, 0.0)],
        free_velocity: &[number(-1.0, 1.0, 0.0), number(1.0, 0.0, 0.0)],
    };
    let mut f = [number(0.0, 0.0, 0.0); 2];
    ConeSolver::new(2, 1).solve(&problem, &mut f);
    let regularized = DMatrix::from_element(2, 2, 1.0) + DMatrix::identity(2, 2) * REGULARIZATION;
    let s = regularized.try_inverse().expect("regular");
    for i in 0..2 {
        assert_near("first", &[f[i].eps1], &[-s[(i, 0)]], 1e-6);
        assert_near("second", &[f[i].eps1eps2], &[s[(0, 0)] * s[(i, 0)]], 1e-6);
    }
}
