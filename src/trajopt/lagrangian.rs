//! What one stage costs, and what the augmented Lagrangian of its constraints adds: as a number, and to second order.
//!
//! λ of a stage holds the multipliers of its constraints one after the other; μ is the same for all of them.
//!
//! [Howell, Jackson, Manchester 2019, ALTRO].

use super::constraint::{Constraint, Multipliers};
use super::cost::Expansion;
use super::curvature;
use super::ddp::Curvature;
use super::dynamics::Dynamics;
use super::problem::Problem;
use super::residual::{Node, ResidualJacobian};
use super::trajectory::Trajectory;

/// λ of a stage before anything is known: zeros.
pub(super) fn no_multipliers<D: Dynamics>(problem: &Problem<D>, stage: usize) -> Vec<f64> {
    let constraints = problem.constraints_at(stage).iter();
    vec![0.0; constraints.map(Constraint::dim).sum()]
}

/// A stage at a state and an input.
pub(super) struct StagePoint<'a, D: Dynamics> {
    pub(super) problem: &'a Problem<D>,
    pub(super) stage: usize,
    pub(super) x: &'a [f64],
    /// Empty at the end of the horizon.
    pub(super) u: &'a [f64],
}

impl<'a, D: Dynamics> StagePoint<'a, D> {
    /// A stage where a trajectory passes it.
    pub(super) fn of(problem: &'a Problem<D>, trajectory: &'a Trajectory, stage: usize) -> Self {
        Self {
            problem,
            stage,
            x: trajectory.states[stage].as_slice(),
            u: trajectory.input(stage),
        }
    }

    /// The cost, which counts times the time step.
    pub(super) fn cost(&self, memory: &mut ResidualJacobian) -> f64 {
        let (cost, factor) = self.problem.cost_at(self.stage);
        factor * cost.evaluate(&self.node(), self.x, self.u, memory)
    }

    /// The penalties of the constraints.
    pub(super) fn penalties(&self, lambda: &[f64], mu: f64, memory: &mut ResidualJacobian) -> f64 {
        let (node, mut rest) = (self.node(), lambda);
        let of_one = |constraint: &Constraint<D>| {
            let (lambda, others) = rest.split_at(constraint.dim());
            rest = others;
            let at = Multipliers { lambda, mu };
            constraint.penalty(&node, self.x, self.u, &at, memory)
        };
        let constraints = self.problem.constraints_at(self.stage);
        constraints.iter().map(of_one).sum()
    }

    /// Cost and penalties to second order, of the Hessian the upper triangle; constraints always as Gauss and Newton have it.
    pub(super) fn expand(
        &self,
        curvature: Curvature,
        (lambda, mu): (&[f64], f64),
        memory: &mut ResidualJacobian,
        out: &mut Expansion,
    ) {
        let (node, (cost, factor)) = (self.node(), self.problem.cost_at(self.stage));
        out.clear();
        if curvature == Curvature::GaussNewton {
            cost.add_expansion(&node, self.x, self.u, factor, memory, out);
        } else {
            curvature::add_exact_cost(cost, &node, (self.x, self.u), factor, out);
        }
        let mut rest = lambda;
        for constraint in self.problem.constraints_at(self.stage) {
            let (lambda, others) = rest.split_at(constraint.dim());
            rest = others;
            let at = Multipliers { lambda, mu };
            constraint.add_penalty(&node, self.x, self.u, &at, memory, out);
        }
    }

    /// The largest violation of a constraint.
    pub(super) fn violation(&self, memory: &mut ResidualJacobian) -> f64 {
        let node = self.node();
        let constraints = self.problem.constraints_at(self.stage).iter();
        let excess =
            |constraint: &Constraint<D>| constraint.largest_excess(&node, self.x, self.u, memory);
        constraints.map(excess).fold(0.0, f64::max)
    }

    /// λ ← μ (z − proj z) with z = r + λ/μ.
    pub(super) fn update_multipliers(
        &self,
        lambda: &mut [f64],
        mu: f64,
        memory: &mut ResidualJacobian,
    ) {
        let (node, mut rest) = (self.node(), lambda);
        for constraint in self.problem.constraints_at(self.stage) {
            let (lambda, others) = rest.split_at_mut(constraint.dim());
            rest = others;
            constraint.update_multipliers(&node, self.x, self.u, mu, lambda, memory);
        }
    }

    fn node(&self) -> Node<'a, D> {
        Node {
            dynamics: self.problem.dynamics(),
            stage: self.stage,
        }
    }
}
