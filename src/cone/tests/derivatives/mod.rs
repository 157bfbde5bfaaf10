//! Derivatives equal finite differences, in every mode and at the points between modes.

mod responses;
mod singular;

use super::*;
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

    /// The problem with other parameters.
    fn with<'a, T: Scalar>(&'a self, parameters: &'a [T]) -> ConeProblem<'a, T> {
        let n = self.free_velocity.len();
        let (matrix, rest) = parameters.split_at(n * n);
        let (regularization, rest) = rest.split_at(n);
        let (free_velocity, friction) = rest.split_at(n);
        ConeProblem {
            law: self.law,
            blocks: &self.blocks,
            friction,
            matrix,
            regularization,
            free_velocity,
        }
    }

    /// The forces for other parameters, from the forces `f`.
    fn solve_for<T: Scalar>(&self, parameters: &[T], f: &[f64], kappa: f64) -> Vec<T> {
        let problem = self.with(parameters);
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
    cases.push(Case::new(
        law,
        &[Block::Interval],
        0.4,
        DMatrix::identity(1, 1),
        &[0.7],
    ));
    cases.extend((0..3).map(|_| random.mixed_case(law, [1, 1, 1, 4], 20, 1.0)));
    cases
}

/// Problems as they are, and smoothed.
fn plain_and_smoothed(cases: &[Case]) -> impl Iterator<Item = (&Case, f64)> {
    cases.iter().flat_map(|case| [(case, 0.0), (case, 1e-2)])
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
            Mode::Holding,
            Mode::Yielding,
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
        for (case, kappa) in plain_and_smoothed(&cases(law)[..3]) {
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

// Moved as one body, the box keeps the sum of its forces in step with its velocity, independent of the corners that carry it.
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

#[test]
fn values_have_the_same_bits_for_every_scalar() {
    for law in LAWS {
        for kappa in [0.0, 1e-3] {
            let mut random = Random(40.0);
            let lane: [Case; 4] =
                std::array::from_fn(|_| random.mixed_case(law, [1, 1, 3, 3], 20, 1.0));
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
