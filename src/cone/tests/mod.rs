//! Problems for the tests, and the checks they share.

mod blocks;
mod closed_forms;
mod derivatives;
mod hostile;
mod intervals;
mod optimality;
mod smoothing;
mod sticking;

use super::{Block, Certificate, ConeOptions, ConeProblem, ConeSolver, Law, Mode};
use crate::scalar::Scalar;
use nalgebra::{DMatrix, DVector};

const LAWS: [Law; 2] = [Law::Convex, Law::Coulomb];

/// A problem that owns its numbers.
#[derive(Clone, Debug)]
struct Case {
    law: Law,
    blocks: Vec<Block>,
    friction: Vec<f64>,
    matrix: DMatrix<f64>,
    regularization: Vec<f64>,
    free_velocity: DVector<f64>,
}

/// Forces, certificate and modes.
struct Solution {
    f: DVector<f64>,
    certificate: Certificate,
    modes: Vec<Mode>,
}

impl Case {
    fn new(
        law: Law,
        blocks: &[Block],
        friction: f64,
        matrix: DMatrix<f64>,
        free_velocity: &[f64],
    ) -> Self {
        Self {
            law,
            blocks: blocks.to_vec(),
            friction: vec![friction; blocks.len()],
            regularization: vec![0.0; free_velocity.len()],
            matrix,
            free_velocity: DVector::from_column_slice(free_velocity),
        }
    }

    /// Rows J, inverse masses and the velocities before the contact:  G = J M⁻¹ Jᵀ,  g = J v.
    fn of_jacobian(
        law: Law,
        blocks: &[Block],
        j: &DMatrix<f64>,
        m: &DVector<f64>,
        v: &DVector<f64>,
    ) -> Self {
        let matrix = j * DMatrix::from_diagonal(m) * j.transpose();
        Self::new(law, blocks, 0.5, matrix, (j * v).as_slice())
    }

    fn problem(&self) -> ConeProblem<'_, f64> {
        ConeProblem {
            law: self.law,
            blocks: &self.blocks,
            friction: &self.friction,
            matrix: self.matrix.as_slice(),
            regularization: &self.regularization,
            free_velocity: self.free_velocity.as_slice(),
        }
    }

    fn solver<T: Scalar>(&self, kappa: f64) -> ConeSolver<T> {
        let options = ConeOptions::default().with_smoothing(kappa);
        ConeSolver::new(self.free_velocity.len(), self.blocks.len()).with_options(options)
    }

    fn solve(&self) -> Solution {
        self.solve_smoothed(0.0)
    }

    fn solve_smoothed(&self, kappa: f64) -> Solution {
        let mut f = DVector::zeros(self.free_velocity.len());
        let mut solver = self.solver(kappa);
        let certificate = solver.solve(&self.problem(), f.as_mut_slice());
        let modes = solver.modes().to_vec();
        Solution {
            f,
            certificate,
            modes,
        }
    }

    /// y = (G + diag R) f + g
    fn velocity(&self, f: &DVector<f64>) -> DVector<f64> {
        let r = DVector::from_column_slice(&self.regularization);
        &self.matrix * f + r.component_mul(f) + &self.free_velocity
    }
}

/// Numbers that look random in (−1, 1).
struct Random(f64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 += 1.0;
        let x = (self.0 * 12.9898).sin() * 43758.5453;
        2.0 * (x - x.floor()) - 1.0
    }

    fn vector(&mut self, n: usize) -> DVector<f64> {
        DVector::from_fn(n, |_, _| self.next())
    }

    /// Bilateral rows, rays and cones on so many coordinates with inverse masses over so many decades.
    fn case(&mut self, law: Law, counts: [usize; 3], dof: usize, decades: f64) -> Case {
        let [free, rays, cones] = counts;
        self.mixed_case(law, [free, rays, cones, 0], dof, decades)
    }

    /// A case with intervals after the other blocks.
    fn mixed_case(
        &mut self,
        law: Law,
        [free, rays, cones, intervals]: [usize; 4],
        dof: usize,
        decades: f64,
    ) -> Case {
        let mut blocks = vec![Block::Free(free)];
        blocks.extend(vec![Block::Ray; rays]);
        blocks.extend(vec![Block::Cone; cones]);
        blocks.extend(vec![Block::Interval; intervals]);
        let rows = free + rays + 3 * cones + intervals;
        let j = DMatrix::from_fn(rows, dof, |_, _| self.next());
        let m = self.vector(dof).map(|x| 10_f64.powf(0.5 * decades * x));
        let mut case = Case::of_jacobian(law, &blocks, &j, &m, &self.vector(dof));
        case.friction.fill_with(|| 0.6 + 0.6 * self.next());
        case
    }
}

/// A box of mass 1 and half-size ½ on four corners, normal first, with a velocity of its centre and an angular velocity.
fn box_on_corners(law: Law, v: [f64; 6]) -> Case {
    let mut j = DMatrix::zeros(12, 6);
    for (corner, (x, y)) in [(0.5, 0.5), (0.5, -0.5), (-0.5, 0.5), (-0.5, -0.5)]
        .into_iter()
        .enumerate()
    {
        // v + ω × p with p = (x, y, −½), in the order z, x, y.
        let rows = [
            [0.0, 0.0, 1.0, y, -x, 0.0],
            [1.0, 0.0, 0.0, 0.0, -0.5, -y],
            [0.0, 1.0, 0.0, 0.5, 0.0, x],
        ];
        for (i, row) in rows.iter().enumerate() {
            j.row_mut(3 * corner + i).copy_from_slice(row);
        }
    }
    let m = DVector::from_column_slice(&[1.0, 1.0, 1.0, 6.0, 6.0, 6.0]);
    let v = DVector::from_column_slice(&v);
    Case::of_jacobian(law, &[Block::Cone; 4], &j, &m, &v)
}

#[track_caller]
fn assert_near(name: &str, actual: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(actual.len(), expected.len(), "{name}");
    for (i, (a, e)) in actual.iter().zip(expected).enumerate() {
        let near = (a - e).abs() <= tolerance * (1.0 + e.abs());
        assert!(near, "{name}, entry {i}: {a:e}, not {e:e}");
    }
}
