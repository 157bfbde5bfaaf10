//! Responses of forces, forwards and backwards, and the derivatives of the equations under them.

use super::*;
use crate::cone::jacobian::jacobian_of;
use crate::cone::law::{Piece, equations};

#[test]
fn responses_equal_dual_derivatives() {
    for law in LAWS {
        for (case, kappa) in plain_and_smoothed(&cases(law)) {
            let (n, blocks) = (case.free_velocity.len(), case.blocks.len());
            let mut f = vec![0.0; n];
            let mut solver = case.solver(kappa);
            solver.solve(&case.problem(), &mut f);
            let mut response = DMatrix::identity(n, n);
            let columns = response.as_mut_slice().chunks_exact_mut(n);
            solver.apply_sensitivity(&case.problem(), &f, columns, &mut vec![0.0; 2 * f.len()]);
            // Row by row, backwards.
            let mut friction = DMatrix::zeros(n, blocks);
            for i in 0..n {
                let mut own = vec![0.0; blocks];
                let mut weights: Vec<f64> = (0..n).map(|k| f64::from(k == i)).collect();
                solver.respond_transposed(&case.problem(), &f, &mut weights, &mut own);
                own.iter()
                    .enumerate()
                    .for_each(|(block, &x)| friction[(i, block)] = x);
            }
            for i in 0..n {
                let by_free_velocity = case.derivative(n * n + n + i, &f, kappa);
                assert_near(
                    "δg",
                    response.column(i).as_slice(),
                    &by_free_velocity,
                    SAME_ALGEBRA,
                );
                // δy = f_k δG in row i, of the second row where there is one.
                let k = 1.min(n - 1);
                let by_matrix = case.derivative(k * n + i, &f, kappa);
                let expected = response.column(i) * f[k];
                assert_near("δG", expected.as_slice(), &by_matrix, SAME_ALGEBRA);
            }
            for block in 0..blocks {
                let expected = case.derivative(n * n + 2 * n + block, &f, kappa);
                assert_near(
                    "δμ",
                    friction.column(block).as_slice(),
                    &expected,
                    SAME_ALGEBRA,
                );
            }
        }
    }
}

/// Weights of forces, turned into those of velocities and friction.
struct Transposed<T> {
    by_velocity: Vec<T>,
    by_friction: Vec<T>,
}

impl Case {
    /// Σ wₖ fₖ backwards, for other parameters.
    fn transposed<T: Scalar>(&self, parameters: &[T], kappa: f64) -> Transposed<T> {
        let (n, problem) = (self.free_velocity.len(), self.with(parameters));
        let mut solver = self.solver(kappa);
        let mut f = vec![T::zero(); n];
        assert!(solver.solve(&problem, &mut f).is_converged());
        let mut out = Transposed {
            by_velocity: weights(n).map(T::constant).collect(),
            by_friction: vec![T::zero(); self.blocks.len()],
        };
        let Transposed {
            by_velocity,
            by_friction,
        } = &mut out;
        solver.respond_transposed(&problem, &f, by_velocity, by_friction);
        out
    }
}

fn weights(n: usize) -> impl Iterator<Item = f64> {
    (0..n).map(|k| (k as f64 + 0.5).sin())
}

// Hyper-dual numbers solve the problem itself, in the direction of one number and in another of all.
#[test]
fn transposed_response_and_its_derivative_equal_those_of_the_solution() {
    for law in LAWS {
        for (case, kappa) in plain_and_smoothed(&cases(law)) {
            let (n, values) = (case.free_velocity.len(), case.parameters());
            let direction = |k: usize| 0.1 * (3.0 * k as f64).cos();
            let along = values.iter().enumerate();
            let along = along.map(|(k, &x)| Dual64::new(x, direction(k)));
            let found = case.transposed(&along.collect::<Vec<_>>(), kappa);
            let numbers = found.by_velocity.iter().chain(&found.by_friction);
            let start = case.solve_smoothed(kappa).f;
            for (index, found) in (n * n + n..).zip(numbers) {
                let twice = values.iter().enumerate();
                let twice = twice.map(|(k, &x)| {
                    let own = if k == index { 1.0 } else { 0.0 };
                    HyperDual64::new(x, own, direction(k), 0.0)
                });
                let f = case.solve_for(&twice.collect::<Vec<_>>(), start.as_slice(), kappa);
                let sum = |of: fn(&HyperDual64) -> f64| -> f64 {
                    weights(n).zip(&f).map(|(weight, f)| weight * of(f)).sum()
                };
                let expected = [sum(|f| f.eps1), sum(|f| f.eps1eps2)];
                assert_near(
                    "transposed",
                    &[found.re, found.eps],
                    &expected,
                    SAME_ALGEBRA,
                );
            }
        }
    }
}

#[test]
fn slopes_equal_finite_differences_of_the_equations() {
    let (f, y, mu, kappa) = ([1.1, 0.3, -0.4], [0.2, -0.9, 0.5], 0.6, 0.05);
    let numbers = [f[0], f[1], f[2], y[0], y[1], y[2], mu];
    let mut pieces = vec![
        Piece::Stick,
        Piece::Separated,
        Piece::Frictionless,
        Piece::PathOfRay,
        Piece::Upper,
        Piece::Lower,
        Piece::PathOfInterval,
    ];
    for law in LAWS {
        pieces.extend([Piece::Slip(law), Piece::PathOfCone(law)]);
    }
    for piece in pieces {
        let slopes = jacobian_of(piece, f, y, mu, kappa);
        for k in 0..7 {
            let [after, before] = [1e-6, -1e-6].map(|by| {
                let mut x = numbers;
                x[k] += by;
                equations(piece, [x[0], x[1], x[2]], [x[3], x[4], x[5]], x[6], kappa)
            });
            let actual: [f64; 3] = std::array::from_fn(|i| match k {
                0..3 => slopes.f[i][k],
                3..6 => slopes.y[i][k - 3],
                _ => slopes.mu[i],
            });
            assert_near(
                &format!("{piece:?}, {k}"),
                &actual,
                &std::array::from_fn::<_, 3, _>(|i| (after[i] - before[i]) / 2e-6),
                1e-9,
            );
        }
    }
}
