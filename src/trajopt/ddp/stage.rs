//! Data of one stage: the problem to second order around the trajectory, and the policy.

use nalgebra::DMatrix;

use crate::linearize::Linearization;
use crate::trajopt::constraint::Multipliers;
use crate::trajopt::cost::Expansion;
use crate::trajopt::curvature::Curvature;
use crate::trajopt::lagrangian::no_multipliers;
use crate::trajopt::problem::Problem;
use crate::trajopt::residual::ResidualJacobian;
use crate::trajopt::scratch::Scratch;
use crate::trajopt::system::zero_linearization;
use crate::trajopt::trajectory::Trajectory;

/// One stage; the last has no input, no dynamics and no policy.
#[derive(Clone, Debug)]
pub(super) struct Stage {
    /// [A B]ᵀ by columns, (`ndx` + `nu`) × `ndx`.
    pub(super) jacobian_t: Vec<f64>,
    /// Costs and penalties; of the Hessian the upper triangle.
    pub(super) expansion: Expansion,
    /// Second-order terms of the dynamics, weighed by Vₓ: an upper triangle like that of the costs; empty where they do
    /// not count.
    pub(super) dynamics_hessian: Vec<f64>,
    /// f(xₖ, uₖ) ⊖ xₖ₊₁, length `ndx`.
    pub(super) gap: Vec<f64>,
    /// λ of its constraints, in sequence.
    pub(super) lambda: Vec<f64>,
    /// k of δu = −k − K δx, length `nu`.
    pub(super) feedforward: Vec<f64>,
    /// Kᵀ by columns, `ndx` × `nu`.
    pub(super) gain_t: Vec<f64>,
}

impl Stage {
    pub(super) fn new(problem: &Problem, k: usize) -> Self {
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

/// Working memory of one thread for stages.
pub(super) struct StageScratch {
    /// Working memory of the system.
    pub(super) system: Scratch,
    pub(super) memory: ResidualJacobian,
    linearization: Linearization,
    next: Vec<f64>,
}

impl StageScratch {
    pub(super) fn new(problem: &Problem) -> Self {
        let (system, mut scratch) = (problem.dynamics(), Scratch::new());
        system.prepare(&mut scratch);
        Self {
            system: scratch,
            memory: ResidualJacobian::new(system, problem.largest_dim()),
            linearization: zero_linearization(system),
            next: vec![0.0; system.nx()],
        }
    }

    /// Costs, penalties, dynamics and gap of stage `k` around the trajectory.
    pub(super) fn expand(&mut self, at: &ExpansionPoint<'_>, k: usize, stage: &mut Stage) {
        let system = at.problem.dynamics();
        let point = at.trajectory.stage(at.problem, k);
        let multipliers = Multipliers {
            lambda: &stage.lambda,
            mu: at.penalty,
        };
        let (memory, expansion) = (&mut self.memory, &mut stage.expansion);
        point.expand(at.curvature, &multipliers, memory, expansion);
        stage.dynamics_hessian.clear();
        if k < at.problem.horizon() {
            let (x, u, scratch) = (point.x, point.u, &mut self.system);
            system.linearize(x, u, scratch, &mut self.linearization);
            transpose_into(&self.linearization, &mut stage.jacobian_t);
            if at.has_gaps {
                system.step(x, u, scratch, self.next.as_mut_slice());
                let planned = at.trajectory.states[k + 1].as_slice();
                system.difference(planned, &self.next, stage.gap.as_mut_slice());
            } else {
                stage.gap.fill(0.0);
            }
        }
    }
}

/// Expansion point: trajectory at which a problem is expanded, and its options.
pub(super) struct ExpansionPoint<'a> {
    pub(super) problem: &'a Problem,
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trajopt::tests::{A, B, LAST, Q, R, START, linear_quadratic};

    #[test]
    fn columns_of_the_transposed_jacobian_equal_rows_of_a_and_b() {
        let of = Linearization {
            a: DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 3.0, 4.0]),
            b: DMatrix::from_row_slice(2, 1, &[5.0, 6.0]),
        };
        let mut out = [0.0; 6];
        transpose_into(&of, &mut out);
        assert_eq!(out, [1.0, 2.0, 5.0, 3.0, 4.0, 6.0]);
    }

    // ½ (Q x² + R u²) and x⁺ = a x + b u, whose gap is a x + b u − x⁺.
    #[test]
    fn expanded_stage_equals_the_derivatives_of_cost_and_dynamics() {
        let problem = linear_quadratic(1);
        let mut trajectory = Trajectory::zero_input(&problem);
        trajectory.inputs[0][0] = -0.4;
        let at = ExpansionPoint {
            problem: &problem,
            trajectory: &trajectory,
            curvature: Curvature::GaussNewton,
            penalty: 1.0,
            has_gaps: true,
        };
        let mut scratch = StageScratch::new(&problem);
        let mut stages = [Stage::new(&problem, 0), Stage::new(&problem, 1)];
        for (k, stage) in stages.iter_mut().enumerate() {
            scratch.expand(&at, k, stage);
        }
        let [first, last] = stages;
        assert_eq!(first.jacobian_t, [A, B]);
        assert_eq!(first.expansion.gradient.as_slice(), [Q * START, R * -0.4]);
        assert_eq!(first.expansion.hessian.as_slice(), [Q, 0.0, 0.0, R]);
        assert_eq!(first.gap, [A * START + B * -0.4 - START]);
        assert_eq!(last.expansion.gradient.as_slice(), [LAST * START]);
    }
}
