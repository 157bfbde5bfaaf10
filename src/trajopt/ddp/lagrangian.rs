//! The augmented Lagrangian of the constraints: inner problems without constraints, multipliers that grow into the forces of the
//! constraints, and a penalty that is raised where violations do not shrink.
//!
//! [Howell, Jackson, Manchester 2019, ALTRO].

use super::stage::{Around, Stage};
use crate::trajopt::constraint::Multipliers;
use crate::trajopt::cost::Expansion;
use crate::trajopt::dynamics::Dynamics;
use crate::trajopt::problem::Problem;
use crate::trajopt::residual::{Node, ResidualJacobian};
use crate::trajopt::trajectory::Trajectory;

/// μ, the same for all constraints.
#[derive(Clone, Copy, Debug)]
pub(super) struct Penalty(pub(super) f64);

/// Adds the penalties of stage `k` to its costs.
pub(super) fn add_penalties<D: Dynamics>(
    at: &Around<'_, D>,
    k: usize,
    lambda: &[f64],
    memory: &mut ResidualJacobian,
    out: &mut Expansion,
) {
    let (x, u) = (at.trajectory.states[k].as_slice(), at.trajectory.input(k));
    let dynamics = at.problem.dynamics();
    let node = Node { dynamics, stage: k };
    let mut rest = lambda;
    for constraint in at.problem.constraints_at(k) {
        let (own, others) = rest.split_at(constraint.dim());
        rest = others;
        let at = Multipliers {
            lambda: own,
            mu: at.penalty.0,
        };
        constraint.add_penalty(&node, x, u, &at, memory, out);
    }
}

/// The penalties of stage `k`.
pub(super) fn penalties<D: Dynamics>(
    problem: &Problem<D>,
    (k, x, u): (usize, &[f64], &[f64]),
    lambda: &[f64],
    Penalty(mu): Penalty,
    memory: &mut ResidualJacobian,
) -> f64 {
    let dynamics = problem.dynamics();
    let node = Node { dynamics, stage: k };
    let mut rest = lambda;
    let of_one = |constraint: &crate::trajopt::Constraint<D>| {
        let (own, others) = rest.split_at(constraint.dim());
        rest = others;
        let at = Multipliers { lambda: own, mu };
        constraint.penalty(&node, x, u, &at, memory)
    };
    problem.constraints_at(k).iter().map(of_one).sum()
}

/// The largest violation along a trajectory.
pub(super) fn violation<D: Dynamics>(
    problem: &Problem<D>,
    trajectory: &Trajectory,
    memory: &mut ResidualJacobian,
) -> f64 {
    let dynamics = problem.dynamics();
    let mut largest = 0.0_f64;
    for (stage, x) in trajectory.states.iter().enumerate() {
        let node = Node { dynamics, stage };
        for constraint in problem.constraints_at(stage) {
            let (x, u) = (x.as_slice(), trajectory.input(stage));
            largest = largest.max(constraint.largest_excess(&node, x, u, memory));
        }
    }
    largest
}

/// λ of all stages from the violations along a trajectory.
pub(super) fn update_multipliers<D: Dynamics>(
    problem: &Problem<D>,
    trajectory: &Trajectory,
    Penalty(mu): Penalty,
    stages: &mut [Stage],
    memory: &mut ResidualJacobian,
) {
    let dynamics = problem.dynamics();
    for (k, stage) in stages.iter_mut().enumerate() {
        let node = Node { dynamics, stage: k };
        let (x, u) = (trajectory.states[k].as_slice(), trajectory.input(k));
        let mut rest = stage.lambda.as_mut_slice();
        for constraint in problem.constraints_at(k) {
            let (own, others) = rest.split_at_mut(constraint.dim());
            rest = others;
            constraint.update_multipliers(&node, x, u, mu, own, memory);
        }
    }
}
