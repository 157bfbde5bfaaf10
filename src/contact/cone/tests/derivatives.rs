//! Derivatives equal finite differences, in every mode and at the points between modes.

use super::*;
use crate::contact::cone::REGULARIZATION;
use crate::contact::cone::jacobian::jacobian_of;
use crate::contact::cone::law::{Piece, equations};
use crate::scalar::Lanes;
use num_dual::{Dual64, HyperDual64};

const FINITE_DIFFERENCE: f64 = 2e-6;
const SAME_ALGEBRA: f64 = 1e-9;
/// Of the finite differences: the tolerance of the solver divided by it is still small.
const STEP: f64 = 1e-5;

impl Case {
    /// G, R, g, μ one after the other.
    fn parameters(&self) -> Vec<f64> {
        let matrix = self.matrix.iter().chain(&self.regularization);
        matrix
            .chain(&self.free_velocity)
            .chain(&self.friction)
            .copied()
            .collect()
    }

    /// The forces for other parameters, from the forces `f`.
    fn solve_for<T: Scalar>(&self, parameters: &[T], f: &[f64], kappa: f64) -> Vec<T> {
        let n = self.free_velocity.len();
        let (matrix, rest) = parameters.split_at(n * n);
        let (regularization, rest) = rest.split_at(n);
        let (free_velocity, friction) = rest.split_at(n);
        let (law, blocks) = (self.law, &self.blocks[..]);
        let problem = ConeProblem {
            law,
            blocks,
            friction,
            matrix,
            regularization,
            free_velocity,
        };
        let mut f: Vec<T> = f.iter().map(|&f| T::constant(f)).collect();
        let certificate = self.solver(kappa).solve(&problem, &mut f);
        assert!(certificate.is_converged(), "{certificate:?}");
        f
    }

    /// The forces at a distance along one parameter.
    fn moved(&self, index: usize, by: f64, f: &[f64], kappa: f64) -> DVector<f64> {
        let mut parameters = self.parameters();
        parameters[index] += by;
        DVector::from_vec(self.solve_for(&parameters, f, kappa))
    }

    /// The derivative by one parameter.
    fn derivative(&self, index: usize, f: &[f64], kappa: f64) -> Vec<f64> {
        let mut parameters: Vec<Dual64> =
            self.parameters().into_iter().map(Dual64::from_re).collect();
        parameters[index].eps = 1.0;
        self.solve_for(&parameters, f, kappa)
            .iter()
            .map(|f| f.eps)
            .collect()
    }
}

fn particle(law: Law, free_velocity: [f64; 3]) -> Case {
    let matrix = DMatrix::from_row_slice(3, 3, &[1.0, 0.2, 0.1, 0.2, 0.9, -0.1, 0.1, -0.1, 1.2]);
    Case::new(law, &[Block::Cone], 0.4, matrix, &free_velocity)
}

/// One problem for each mode, and some with many.
fn cases(law: Law) -> Vec<Case> {
    let mut random = Random(20.0);
    let mut cases = vec![
        particle(law, [-1.0, 0.1, 0.05]),
        particle(law, [-1.0, 2.0, 1.0]),
        particle(law, [1.0, 0.3, 0.1]),
    ];
    cases.extend((0..4).map(|_| random.case(law, [1, 2, 3], 20, 1.0)));
    cases
}

#[track_caller]
fn assert_derivatives_equal_differences(case: &Case, kappa: f64) {
    let solution = case.solve_smoothed(kappa);
    assert!(solution.certificate.is_converged());
    let f = solution.f.as_slice();
    for index in 0..case.parameters().len() {
        let ahead = case.moved(index, STEP, f, kappa);
        let behind = case.moved(index, -STEP, f, kappa);
        let expected = (ahead - behind) / (2.0 * STEP);
        let name = format!("{:?}, parameter {index}, {:?}", case.law, solution.modes);
        assert_near(
            &name,
            &case.derivative(index, f, kappa),
            expected.as_slice(),
            FINITE_DIFFERENCE,
        );
    }
}

#[test]
fn derivatives_in_all_parameters_equal_finite_differences() {
    for law in LAWS {
        let mut seen = Vec::new();
        for case in cases(law) {
            seen.extend(case.solve().modes);
            assert_derivatives_equal_differences(&case, 0.0);
        }
        for mode in [
            Mode::Sticking,
            Mode::Sliding,
            Mode::Separated,
            Mode::Pressing,
            Mode::Bilateral,
        ] {
            assert!(seen.contains(&mode), "{law:?} was never {mode:?}");
        }
    }
}

#[test]
fn derivatives_of_smoothed_laws_equal_finite_differences() {
    for law in LAWS {
        for case in cases(law) {
            assert_derivatives_equal_differences(&case, 1e-2);
        }
    }
}

// Every second derivative by pairs of parameters, against differences of first ones.
#[test]
fn second_derivatives_equal_finite_differences_of_first_ones() {
    for law in LAWS {
        for (case, kappa) in cases(law)
            .iter()
            .take(3)
            .flat_map(|case| [(case, 0.0), (case, 1e-2)])
        {
            let f = case.solve_smoothed(kappa).f;
            let count = case.parameters().len();
            for (i, k) in [
                (0, 0),
                (4, 13),
                (1, 12),
                (12, 14),
                (13, 13),
                (count - 1, 13),
                (count - 1, count - 1),
            ] {
                let lifted = case.parameters().into_iter().map(HyperDual64::from_re);
                let mut parameters: Vec<HyperDual64> = lifted.collect();
                parameters[i].eps1 = 1.0;
                parameters[k].eps2 = 1.0;
                let solved = case.solve_for(&parameters, f.as_slice(), kappa);
                let actual: Vec<f64> = solved.iter().map(|f| f.eps1eps2).collect();
                let first = |by: f64| {
                    let mut moved = case.clone();
                    move_parameter(&mut moved, k, by);
                    DVector::from_vec(moved.derivative(i, f.as_slice(), kappa))
                };
                let expected = (first(STEP) - first(-STEP)) / (2.0 * STEP);
                let name = format!("{law:?} κ {kappa}, parameters {i} and {k}");
                assert_near(&name, &actual, expected.as_slice(), 1e-5);
            }
        }
    }
}

fn move_parameter(case: &mut Case, index: usize, by: f64) {
    let n = case.free_velocity.len();
    match index {
        i if i < n * n => case.matrix[i] += by,
        i if i < n * n + n => case.regularization[i - n * n] += by,
        i if i < n * n + 2 * n => case.free_velocity[i - n * n - n] += by,
        i => case.friction[i - n * n - 2 * n] += by,
    }
}

#[test]
fn responses_equal_dual_derivatives() {
    for law in LAWS {
        for (case, kappa) in cases(law)
            .iter()
            .flat_map(|case| [(case, 0.0), (case, 1e-2)])
        {
            let (n, blocks) = (case.free_velocity.len(), case.blocks.len());
            let mut f = vec![0.0; n];
            let mut solver = case.solver(kappa);
            solver.solve(&case.problem(), &mut f);
            let mut response = DMatrix::zeros(n, n);
            let mut friction = DMatrix::zeros(n, blocks);
            solver.response(response.as_mut_slice());
            solver.friction_response(friction.as_mut_slice());
            for i in 0..n {
                let by_free_velocity = case.derivative(n * n + n + i, &f, kappa);
                assert_near(
                    "δg",
                    response.column(i).as_slice(),
                    &by_free_velocity,
                    SAME_ALGEBRA,
                );
                // δy = f₁ δG in row i.
                let by_matrix = case.derivative(n + i, &f, kappa);
                let expected = response.column(i) * f[1];
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
        let n = self.free_velocity.len();
        let (matrix, rest) = parameters.split_at(n * n);
        let (regularization, rest) = rest.split_at(n);
        let (free_velocity, friction) = rest.split_at(n);
        let problem = ConeProblem {
            law: self.law,
            blocks: &self.blocks,
            friction,
            matrix,
            regularization,
            free_velocity,
        };
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
        for (case, kappa) in cases(law)
            .iter()
            .flat_map(|case| [(case, 0.0), (case, 1e-2)])
        {
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

// Moved as one body, the box keeps the sum of its forces in step with its velocity whichever corners carry it.
#[test]
fn derivatives_over_redundant_corners_are_those_of_the_body() {
    for law in LAWS {
        let case = box_on_corners(law, [0.01, 0.0, -0.2, 0.01, 0.0, 0.02]);
        let push = box_on_corners(law, [1.0, 0.0, -2.0, 0.0, 0.0, 0.0]).free_velocity;
        let mut parameters: Vec<Dual64> =
            case.parameters().into_iter().map(Dual64::from_re).collect();
        for i in 0..12 {
            parameters[144 + 12 + i].eps = push[i];
        }
        let f = case.solve_for(&parameters, case.solve().f.as_slice(), 0.0);
        let sum = |row: usize| (0..4).map(|corner| f[3 * corner + row].eps).sum::<f64>();
        assert_near("sums", &[sum(0), sum(1), sum(2)], &[2.0, -1.0, 0.0], 1e-9);
        let largest = f.iter().map(|f| f.eps.abs()).fold(0.0, f64::max);
        assert!(largest < 3.0, "{largest}");
    }
}

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
                // At the tip of the cone the derivative is that of separation, whichever way the parameter pushes.
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

#[test]
fn values_have_the_same_bits_for_every_scalar() {
    for law in LAWS {
        for kappa in [0.0, 1e-3] {
            let mut random = Random(40.0);
            let lane: [Case; 4] = std::array::from_fn(|_| random.case(law, [1, 1, 3], 20, 1.0));
            let start = vec![0.1; lane[0].free_velocity.len()];
            let solved: Vec<Vec<f64>> = lane
                .iter()
                .map(|case| case.solve_for(&case.parameters(), &start, kappa))
                .collect();
            let parameters: Vec<Lanes<4>> = (0..lane[0].parameters().len())
                .map(|i| Lanes::from_values(|l| lane[l].parameters()[i]))
                .collect();
            let lanes = lane[0].solve_for(&parameters, &start, kappa);
            for (l, case) in lane.iter().enumerate() {
                let dual = case.parameters().into_iter().map(|x| Dual64::new(x, 1.0));
                let duals = case.solve_for(&dual.collect::<Vec<_>>(), &start, kappa);
                for i in 0..start.len() {
                    assert_eq!(
                        solved[l][i].to_bits(),
                        lanes[i].0[l].to_bits(),
                        "lane {l}, row {i}"
                    );
                    assert_eq!(
                        solved[l][i].to_bits(),
                        duals[i].re.to_bits(),
                        "dual {l}, row {i}"
                    );
                }
            }
        }
    }
}

#[test]
fn slopes_equal_dual_derivatives_of_the_equations() {
    let (f, y, mu, kappa) = ([1.1, 0.3, -0.4], [0.2, -0.9, 0.5], 0.6, 0.05);
    let numbers = [f[0], f[1], f[2], y[0], y[1], y[2], mu];
    let mut pieces = vec![
        Piece::Stick,
        Piece::Separated,
        Piece::Frictionless,
        Piece::PathOfRay,
    ];
    for law in LAWS {
        pieces.extend([Piece::Slip(law), Piece::PathOfCone(law)]);
    }
    for piece in pieces {
        let slopes = jacobian_of(piece, f, y, mu, kappa);
        for k in 0..7 {
            let x: [Dual64; 7] =
                std::array::from_fn(|i| Dual64::new(numbers[i], f64::from(i == k)));
            let e = equations(piece, [x[0], x[1], x[2]], [x[3], x[4], x[5]], x[6], kappa);
            let actual: [f64; 3] = std::array::from_fn(|i| match k {
                0..3 => slopes.f[i][k],
                3..6 => slopes.y[i][k - 3],
                _ => slopes.mu[i],
            });
            assert_near(
                &format!("{piece:?}, {k}"),
                &actual,
                &e.map(|e| e.eps),
                1e-14,
            );
        }
    }
}
