//! Moments bounded by normal forces, as blocks of the force problem: their law on random problems, and derivatives beside differences.

use dualbody::Scalar;
use dualbody::autodiff::{VectorFunction, jacobian};
use dualbody::cone::{Block, ConeProblem, ConeSolver, Law, Status};
use nalgebra::{DMatrix, DVector};

/// Two contacts, the first with both moments, the second with one of rolling.
const BLOCKS: [Block; 5] = [
    Block::Cone,
    Block::Spin,
    Block::Roll,
    Block::Cone,
    Block::Roll,
];
const FIRST: [usize; 5] = [0, 3, 4, 6, 9];
const ROWS: usize = 11;
const NORMALS: [usize; 5] = [0, 0, 0, 6, 6];

/// A problem with numbers of no meaning from a seed; coefficients of moments are small, so that some slip and some hold.
struct Case {
    law: Law,
    matrix: DMatrix<f64>,
    free_velocity: DVector<f64>,
    friction: [f64; 5],
    regularization: f64,
}

impl Case {
    fn new(law: Law, seed: usize) -> Self {
        let number = |k: usize| (1.7 * k as f64 + 0.91 * seed as f64 + 0.37 * (k * k) as f64).sin();
        let root = DMatrix::from_fn(ROWS, ROWS + 2, |i, j| number(20 * i + j));
        let mut free_velocity = DVector::from_fn(ROWS, |i, _| 0.6 * number(1000 + i));
        (free_velocity[0], free_velocity[6]) = (-1.5, -1.0);
        Self {
            law,
            matrix: &root * root.transpose() / 4.0,
            free_velocity,
            friction: [0.6, 0.15, 0.3, 0.4, 0.05 + 0.2 * number(7).abs()],
            regularization: if seed.is_multiple_of(2) { 0.0 } else { 0.05 },
        }
    }

    /// Coefficients, free velocities, and the diagonal of G, which are moved.
    fn numbers(&self) -> Vec<f64> {
        let diagonal = self.matrix.diagonal();
        let all = self
            .friction
            .iter()
            .chain(&self.free_velocity)
            .chain(&diagonal);
        all.copied().collect()
    }

    fn solve<T: Scalar>(&self, numbers: &[T]) -> (Vec<T>, Status) {
        let (friction, rest) = numbers.split_at(BLOCKS.len());
        let (free_velocity, diagonal) = rest.split_at(ROWS);
        let mut matrix: Vec<T> = self.matrix.iter().map(|&x| T::constant(x)).collect();
        for (k, &x) in diagonal.iter().enumerate() {
            matrix[k * (ROWS + 1)] = x;
        }
        let problem = ConeProblem {
            law: self.law,
            blocks: &BLOCKS,
            friction,
            matrix: &matrix,
            regularization: &[T::constant(self.regularization); ROWS],
            free_velocity,
        };
        let mut f = vec![T::constant(0.0); ROWS];
        let status = ConeSolver::new(ROWS, BLOCKS.len()).solve(&problem, &mut f);
        (f, status.status)
    }
}

impl VectorFunction for Case {
    fn n_outputs(&self) -> usize {
        ROWS
    }

    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        y.copy_from_slice(&self.solve(x).0);
    }
}

fn cases() -> impl Iterator<Item = (String, Case)> {
    [Law::Convex, Law::Coulomb]
        .into_iter()
        .flat_map(|law| (0..40).map(move |seed| (format!("{law:?} {seed}"), Case::new(law, seed))))
}

// ‖m‖ ≤ c fₙ; y = 0 inside, and at the bound m against y.
#[test]
fn moments_hold_or_act_against_the_rotation_at_their_bound() {
    let (mut holding, mut yielding) = (0, 0);
    for (what, case) in cases() {
        let (f, status) = case.solve(&case.numbers());
        assert_eq!(status, Status::Converged, "{what}");
        let f = DVector::from_vec(f);
        let y = &case.matrix * &f + &f * case.regularization + &case.free_velocity;
        for (k, block) in BLOCKS.iter().enumerate() {
            let range = FIRST[k]..FIRST[k] + block.rows();
            let rows = |x: &DVector<f64>| x.rows(range.start, range.len()).into_owned();
            let (m, y) = (rows(&f), rows(&y));
            if *block == Block::Cone {
                let across = m.rows(1, 2).norm();
                assert!(across <= case.friction[k] * m[0] + 1e-9, "{what}");
                continue;
            }
            let bound = case.friction[k] * f[NORMALS[k]];
            let size = m.norm();
            assert!(size <= bound + 1e-9, "{what} {k}: {size} {bound}");
            if size < bound - 1e-7 {
                holding += 1;
                assert!(y.norm() < 1e-8, "{what} {k}: {y}");
            } else if bound > 0.0 {
                yielding += 1;
                // m = −b y / ‖y‖
                let along = &y * (-bound / y.norm());
                assert!((along - m).norm() < 1e-7, "{what} {k}");
            }
        }
    }
    assert!(holding > 20 && yielding > 20, "{holding} {yielding}");
}

#[test]
fn derivatives_of_forces_equal_differences() {
    const BY: f64 = 1e-6;
    for (what, case) in cases() {
        let at = case.numbers();
        let found = jacobian(&case, &at);
        for k in 0..at.len() {
            let forces = |by: f64| {
                let mut moved = at.clone();
                moved[k] += by;
                DVector::from_vec(case.solve(&moved).0)
            };
            let expected = (forces(BY) - forces(-BY)) / (2.0 * BY);
            let error = (found.column(k) - &expected).amax() / expected.amax().max(1.0);
            assert!(error < 1e-5, "{what} {k}: {error:e}");
        }
    }
}

// c = 0 leaves the problem of the cones alone.
#[test]
fn without_coefficients_there_are_no_moments() {
    for (what, mut case) in cases() {
        (case.friction[1], case.friction[2], case.friction[4]) = (0.0, 0.0, 0.0);
        let (f, status) = case.solve(&case.numbers());
        assert_eq!(status, Status::Converged, "{what}");
        assert!(
            f[3..6].iter().chain(&f[9..]).all(|m| *m == 0.0),
            "{what}: {f:?}"
        );
    }
}

#[test]
#[should_panic(expected = "moments follow the cone whose normal force bounds them")]
fn moments_without_a_cone_are_refused() {
    let problem = ConeProblem {
        law: Law::Coulomb,
        blocks: &[Block::Spin],
        friction: &[0.1],
        matrix: &[1.0],
        regularization: &[0.0],
        free_velocity: &[1.0],
    };
    let _ = ConeSolver::new(1, 1).solve(&problem, &mut [0.0]);
}
