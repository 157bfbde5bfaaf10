//! The quadratic program of one iteration: which step improves most, as far as second derivatives of the costs and
//! first ones of all else tell.
//!
//! ```text
//!   min  ½ δzᵀ (H + σ) δz + gᵀ δz + ρ Σ s
//!   s.t. defects + J δz = 0,   bounds on inputs,   lower − s ≤ r + R δz ≤ upper + s,   s ≥ 0
//! ```
//!
//! A slack s for each bounded entry r of a constraint: the program has a solution whatever the constraints ask, and
//! with a large enough ρ the slacks are zero where they can be [Nocedal, Wright 2006, section 18.5]. Defects need none:
//! from any start and with any inputs the linearised system goes somewhere.

use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus};

use super::approximation::Approximation;
use super::layout::Layout;
use super::points::Points;
use super::sparse::Sparse;
use crate::trajopt::problem::Problem;

/// Relative accuracy that is asked of the solver of the program.
const ACCURACY: f64 = 1e-10;
/// Accuracy that is accepted if the solver cannot reach more.
const REDUCED_ACCURACY: f64 = 1e-6;
/// Iterations of the interior-point method; some twenty are usual.
const MOST_ITERATIONS: u32 = 100;

/// The program with its solver, made once for a problem: from iteration to iteration only numbers change.
pub(super) struct QpData {
    pub(super) layout: Layout,
    hessian: Sparse,
    constraints: Sparse,
    /// Gradient of the costs; of the slacks ρ.
    gradient: Vec<f64>,
    bounds: Vec<f64>,
    solver: Option<DefaultSolver<f64>>,
}

/// A step, and the multipliers that go with it.
#[derive(Clone, Debug, Default)]
pub(super) struct Step {
    /// (δx, δu) of one point after the other.
    pub(super) dz: Vec<f64>,
    /// Violations of the constraints that the step leaves, to first order.
    pub(super) slacks: Vec<f64>,
    /// Multipliers of all rows.
    pub(super) multipliers: Vec<f64>,
}

/// σ and ρ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Weights {
    pub(super) regularization: f64,
    pub(super) penalty: f64,
}

impl QpData {
    pub(super) fn new(problem: &Problem, at: &Approximation) -> Self {
        let layout = Layout::new(problem, at);
        let columns = layout.columns();
        let hessian = Sparse::new(columns, columns, |out| layout.hessian(at, 0.0, out));
        let constraints = Sparse::new(layout.rows(), columns, |out| {
            layout.constraints(at, out);
        });
        Self {
            hessian,
            constraints,
            gradient: vec![0.0; columns],
            bounds: vec![0.0; layout.rows()],
            solver: None,
            layout,
        }
    }

    /// Copies the entries of the approximation.
    pub(super) fn refresh(&mut self, problem: &Problem, at: &Approximation, points: &Points) {
        let Self { layout, .. } = self;
        self.constraints.fill(|out| layout.constraints(at, out));
        layout.gradient(at, &mut self.gradient);
        layout.bounds(problem, at, points, &mut self.bounds);
    }

    /// The best step; none where the solver finds none.
    pub(super) fn solve(&mut self, at: &mut Approximation, weights: Weights) -> Option<Step> {
        let layout = &self.layout;
        if layout.columns() == 0 {
            // Nothing moves.
            return Some(Step::default());
        }
        self.hessian
            .fill(|out| layout.hessian(at, weights.regularization, out));
        self.gradient[layout.slacks()].fill(weights.penalty);
        let numbers = self
            .hessian
            .values()
            .iter()
            .chain(self.constraints.values());
        let mut numbers = numbers.chain(&self.gradient).chain(&self.bounds);
        if !numbers.all(|x| x.is_finite()) || !at.is_convex(weights.regularization) {
            return None;
        }
        let slacks = self.layout.slacks();
        let solver = self.prepared_solver();
        solver.solve();
        let solution = &solver.solution;
        let is_solved = matches!(
            solution.status,
            SolverStatus::Solved | SolverStatus::AlmostSolved
        );
        is_solved.then(|| Step {
            dz: solution.x[..slacks.start].to_vec(),
            slacks: solution.x[slacks].to_vec(),
            multipliers: solution.z.clone(),
        })
    }

    /// The solver with the numbers of now.
    fn prepared_solver(&mut self) -> &mut DefaultSolver<f64> {
        let (p, a) = (&self.hessian, &self.constraints);
        let (q, b) = (&self.gradient, &self.bounds);
        // Where numbers have changed so much that an update is refused, a new solver takes them.
        let updated = self.solver.take().and_then(|mut solver| {
            let update = solver.update_data(p.values(), q, a.values(), b);
            update.is_ok().then_some(solver)
        });
        let solver = updated.unwrap_or_else(|| {
            let cones = self.layout.cones();
            DefaultSolver::new(&p.matrix, q, &a.matrix, b, &cones, settings())
                .expect("a program whose parts fit together")
        });
        self.solver.insert(solver)
    }

    /// Residual of the Karush–Kuhn–Tucker conditions at the point with the multipliers of a step: the largest entry
    /// of  g + Jᵀ λ,  and the largest product of a multiplier and the distance to its bound.
    pub(super) fn optimality_error(&self, step: &Step) -> f64 {
        let lambda = &step.multipliers;
        let slopes = (0..self.layout.slacks().start).map(|j| {
            let column = self.constraints.column(j);
            let forces = column.map(|(row, value)| value * lambda[row]);
            (self.gradient[j] + forces.sum::<f64>()).abs()
        });
        let inequalities = self.layout.equalities()..self.layout.rows();
        let products = inequalities.map(|row| (lambda[row] * self.bounds[row].max(0.0)).abs());
        slopes.chain(products).fold(0.0, f64::max)
    }

    /// gᵀ δz of the costs.
    pub(super) fn slope(&self, step: &Step) -> f64 {
        let both = step.dz.iter().zip(&self.gradient);
        both.map(|(dz, g)| dz * g).sum()
    }

    /// Largest entry of the gradient of the costs.
    pub(super) fn largest_gradient(&self) -> f64 {
        let gradient = &self.gradient[..self.layout.slacks().start];
        gradient.iter().fold(0.0, |max, g| max.max(g.abs()))
    }

    /// The multipliers of the defects.
    pub(super) fn defect_multipliers<'s>(&self, step: &'s Step) -> &'s [f64] {
        &step.multipliers[self.layout.defects()]
    }

    /// Puts the defects and constraints of another trajectory, reached by a step, in the place of those of this one, so
    /// that the next solution corrects them.
    pub(super) fn correct(&mut self, there: &Approximation, step: &Step) {
        self.layout
            .correct(there, &self.constraints, &step.dz, &mut self.bounds);
    }
}

fn settings() -> DefaultSettings<f64> {
    DefaultSettings {
        verbose: false,
        max_iter: MOST_ITERATIONS,
        // Presolving would take rows away, and numbers could not be renewed.
        presolve_enable: false,
        tol_gap_abs: ACCURACY,
        tol_gap_rel: ACCURACY,
        tol_feas: ACCURACY,
        reduced_tol_gap_abs: REDUCED_ACCURACY,
        reduced_tol_gap_rel: REDUCED_ACCURACY,
        reduced_tol_feas: REDUCED_ACCURACY,
        ..DefaultSettings::default()
    }
}
