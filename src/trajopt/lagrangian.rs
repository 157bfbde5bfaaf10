//! Cost of one stage with the terms of the augmented Lagrangian of its constraints: as a number, and to second order.
//!
//! λ of a stage holds the multipliers of its constraints one after the other; μ is the same for all of them.
//!
//! [Howell, Jackson, Manchester 2019, ALTRO].

use super::constraint::{Constraint, Multipliers};
use super::cost::Expansion;
use super::curvature::{self, Curvature};
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
        self.problem.node(self.stage)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Scalar;
    use crate::trajopt::{Activation, Cost, InputError, Residual, StateError};

    /// Two numbers that an input bends: x⁺ = x, in steps of 0.1 s.
    struct Pair;
    impl Dynamics for Pair {
        fn nx(&self) -> usize {
            2
        }
        fn nu(&self) -> usize {
            1
        }
        fn time_step(&self) -> f64 {
            0.1
        }
        fn step<T: Scalar>(&self, x: &[T], _: &[T], next: &mut [T]) {
            next.copy_from_slice(x);
        }
    }

    /// x₀ x₁ + u, and x₁² − 3 u.
    struct Bent;
    impl Residual<Pair> for Bent {
        fn dim(&self, _: &Pair) -> usize {
            2
        }
        fn eval<T: Scalar>(&self, _: &Node<'_, Pair>, x: &[T], u: &[T], r: &mut [T]) {
            r[0] = x[0] * x[1] + u[0];
            r[1] = x[1] * x[1] - u[0] * 3.0;
        }
    }

    /// A stage under an equation, an inequality that is active and one that is not, before which stands a constraint of another
    /// length.
    fn problem() -> Problem<Pair> {
        let cost = Cost::new()
            .with(2.0, Activation::Quadratic, StateError::to(&[0.3, 0.1]))
            .with(3.0, Activation::Quadratic, InputError::to(&[1.0]));
        Problem::new(Pair, 1, &[0.7, -0.4])
            .with_stage_cost(cost)
            .with_constraint(Constraint::within(InputError::to(&[0.0]), &[-1.0], &[9.0]))
            .with_constraint(Constraint::within(Bent, &[0.1, -9.0], &[0.1, 9.0]))
            .with_constraint(Constraint::within(
                StateError::to(&[0.0, 0.0]),
                &[-9.0, -0.2],
                &[0.5, 9.0],
            ))
    }

    const LAMBDA: [f64; 5] = [-0.2, 0.8, 0.1, 0.5, -0.3];
    const MU: f64 = 7.0;
    const AT: [f64; 3] = [0.7, -0.4, 0.25];

    fn point<'a>(problem: &'a Problem<Pair>, z: &'a [f64; 3]) -> StagePoint<'a, Pair> {
        let (x, u) = z.split_at(2);
        StagePoint {
            problem,
            stage: 0,
            x,
            u,
        }
    }

    fn memory(problem: &Problem<Pair>) -> ResidualJacobian {
        ResidualJacobian::new(problem.dynamics(), problem.largest_dim())
    }

    #[test]
    fn gradient_under_multipliers_equals_finite_differences_of_the_price() {
        let problem = problem();
        let mut memory = memory(&problem);
        for curvature in [Curvature::GaussNewton, Curvature::Exact] {
            let mut out = Expansion::zeros(3);
            point(&problem, &AT).expand(curvature, (&LAMBDA, MU), &mut memory, &mut out);
            for i in 0..3 {
                let mut price = |step: f64| {
                    let mut z = AT;
                    z[i] += step;
                    let at = point(&problem, &z);
                    at.cost(&mut memory) + at.penalties(&LAMBDA, MU, &mut memory)
                };
                const STEP: f64 = 1e-5;
                let slope = (price(STEP) - price(-STEP)) / (2.0 * STEP);
                assert!((out.gradient[i] - slope).abs() < 1e-8, "{curvature:?}, {i}");
                assert!((out.value - price(0.0)).abs() < 1e-14, "{curvature:?}");
            }
        }
    }

    // The slope of the penalty in r is μ (z − proj z), which is the new λ.
    #[test]
    fn new_multipliers_equal_the_slopes_of_the_penalty() {
        let problem = problem();
        let (mut memory, mut lambda) = (memory(&problem), LAMBDA);
        let at = point(&problem, &AT);
        at.update_multipliers(&mut lambda, MU, &mut memory);
        // r = 0.25, (−0.03, −0.59), (0.7, −0.4)
        let expected = [
            0.0,
            LAMBDA[1] + MU * (-0.03 - 0.1),
            0.0,
            LAMBDA[3] + MU * (0.7 - 0.5),
            LAMBDA[4] + MU * (-0.4 + 0.2),
        ];
        for (is, expected) in lambda.iter().zip(expected) {
            assert!((is - expected).abs() < 1e-14, "{is} {expected}");
        }
        assert!((at.violation(&mut memory) - 0.2).abs() < 1e-14);
        assert_eq!(no_multipliers(&problem, 0).len(), lambda.len());
        assert!(no_multipliers(&problem, 1).is_empty());
    }
}
