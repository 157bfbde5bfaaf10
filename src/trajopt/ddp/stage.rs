//! Data of one stage: the problem to second order around the trajectory, and the policy.

use nalgebra::DMatrix;

use crate::linearize::Linearization;
use crate::trajopt::cost::Expansion;
use crate::trajopt::curvature::Curvature;
use crate::trajopt::dynamics::{Dynamics, Stepper, zero_linearization};
use crate::trajopt::lagrangian::{StagePoint, no_multipliers};
use crate::trajopt::problem::Problem;
use crate::trajopt::residual::ResidualJacobian;
use crate::trajopt::trajectory::Trajectory;

/// One stage; the last has no input, no dynamics and no policy.
#[derive(Clone, Debug)]
pub(super) struct Stage {
    /// [A B]ᵀ by columns, (`ndx` + `nu`) × `ndx`.
    pub(super) jacobian_t: Vec<f64>,
    /// Costs and penalties; of the Hessian the upper triangle.
    pub(super) expansion: Expansion,
    /// Second-order terms of the dynamics, weighed by Vₓ: an upper triangle like that of the costs; empty where they do not count.
    pub(super) dynamics_hessian: Vec<f64>,
    /// f(xₖ, uₖ) ⊖ xₖ₊₁, length `ndx`.
    pub(super) gap: Vec<f64>,
    /// λ of its constraints, one after the other.
    pub(super) lambda: Vec<f64>,
    /// k of δu = −k − K δx, length `nu`.
    pub(super) feedforward: Vec<f64>,
    /// Kᵀ by columns, `ndx` × `nu`.
    pub(super) gain_t: Vec<f64>,
}

impl Stage {
    pub(super) fn new<D: Dynamics>(problem: &Problem<D>, k: usize) -> Self {
        let ndx = problem.dynamics().ndx();
        let (nu, steps) = match k == problem.horizon() {
            true => (0, 0),
            false => (problem.dynamics().nu(), 1),
        };
        Self {
            jacobian_t: vec![0.0; steps * (ndx + nu) * ndx],
            expansion: Expansion::zeros(ndx + nu),
            dynamics_hessian: Vec::new(),
            gap: vec![0.0; ndx],
            lambda: no_multipliers(problem, k),
            feedforward: vec![0.0; nu],
            gain_t: vec![0.0; ndx * nu],
        }
    }
}

/// Working memory of one thread.
pub(super) struct Worker<D> {
    pub(super) stepper: Box<dyn Stepper<D>>,
    pub(super) memory: ResidualJacobian,
    linearization: Linearization,
    next: Vec<f64>,
}

impl<D: Dynamics> Worker<D> {
    pub(super) fn new(problem: &Problem<D>) -> Self {
        let dynamics = problem.dynamics();
        Self {
            stepper: dynamics.stepper(),
            memory: ResidualJacobian::new(dynamics, problem.largest_dim()),
            linearization: zero_linearization(dynamics),
            next: vec![0.0; dynamics.nx()],
        }
    }

    /// Costs, penalties, dynamics and gap of stage `k` around the trajectory.
    pub(super) fn expand(&mut self, at: &Around<'_, D>, k: usize, stage: &mut Stage) {
        let dynamics = at.problem.dynamics();
        let point = StagePoint::of(at.problem, at.trajectory, k);
        let multipliers = (stage.lambda.as_slice(), at.penalty);
        let (memory, expansion) = (&mut self.memory, &mut stage.expansion);
        point.expand(at.curvature, multipliers, memory, expansion);
        stage.dynamics_hessian.clear();
        if k < at.problem.horizon() {
            let (x, u) = (point.x, point.u);
            self.stepper
                .linearize(dynamics, x, u, &mut self.linearization);
            transpose_into(&self.linearization, &mut stage.jacobian_t);
            if at.has_gaps {
                self.stepper.step(dynamics, x, u, &mut self.next);
                let planned = at.trajectory.states[k + 1].as_slice();
                dynamics.difference(planned, &self.next, &mut stage.gap);
            } else {
                stage.gap.fill(0.0);
            }
        }
    }
}

/// Around what a problem is expanded.
pub(super) struct Around<'a, D: Dynamics> {
    pub(super) problem: &'a Problem<D>,
    pub(super) trajectory: &'a Trajectory,
    pub(super) curvature: Curvature,
    /// μ, the same for all constraints.
    pub(super) penalty: f64,
    pub(super) has_gaps: bool,
}

/// [A B]ᵀ.
fn transpose_into(of: &Linearization, out: &mut [f64]) {
    let ndx = of.a.nrows();
    let nz = ndx + of.b.ncols();
    let transposed = |m: &DMatrix<f64>, first: usize, out: &mut [f64]| {
        for (j, column) in m.as_slice().chunks_exact(ndx.max(1)).enumerate() {
            let entries = out[first + j..].iter_mut().step_by(nz);
            entries.zip(column).for_each(|(out, &x)| *out = x);
        }
    };
    transposed(&of.a, 0, out);
    transposed(&of.b, ndx, out);
}
