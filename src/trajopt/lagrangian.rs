//! Cost of one stage with the terms of the augmented Lagrangian of its constraints: as a number, and to second order.
//!
//! λ of a stage holds the multipliers of its constraints in sequence; μ is the same for all of them.
//!
//! [Howell, Jackson, Manchester 2019, ALTRO].

use super::constraint::{Constraint, Multipliers};
use super::cost::{Expansion, Point};
use super::curvature::Curvature;
use super::problem::Problem;
use super::residual::ResidualJacobian;

/// λ of a stage before anything is known: zeros.
pub(super) fn no_multipliers(problem: &Problem, stage: usize) -> Vec<f64> {
    let dims = problem.constraints_at(stage).iter().map(Constraint::dim);
    vec![0.0; dims.sum()]
}

/// A stage at a state and an input.
pub(super) struct StagePoint<'a> {
    pub(super) problem: &'a Problem,
    pub(super) stage: usize,
    pub(super) x: &'a [f64],
    /// Empty at the end of the horizon.
    pub(super) u: &'a [f64],
}

impl<'a> StagePoint<'a> {
    /// The cost, which counts times the time step.
    pub(super) fn cost(&self, memory: &mut ResidualJacobian) -> f64 {
        let cost = self.problem.cost_at(self.stage);
        self.problem.cost_factor(self.stage) * cost.evaluate(self.point(), memory)
    }

    /// The penalties of the constraints.
    pub(super) fn penalties(
        &self,
        multipliers: &Multipliers<'_>,
        memory: &mut ResidualJacobian,
    ) -> f64 {
        let (at, mut first, mut sum) = (self.point(), 0, 0.0);
        for constraint in self.problem.constraints_at(self.stage) {
            let own = multipliers.part(&mut first, constraint.dim());
            sum += constraint.penalty(at, &own, memory);
        }
        sum
    }

    /// Cost and penalties to second order, of the Hessian the upper triangle; constraints always as Gauss and Newton
    /// have it.
    pub(super) fn expand(
        &self,
        curvature: Curvature,
        multipliers: &Multipliers<'_>,
        memory: &mut ResidualJacobian,
        out: &mut Expansion,
    ) {
        let (at, factor) = (self.point(), self.problem.cost_factor(self.stage));
        let cost = self.problem.cost_at(self.stage);
        out.clear();
        match curvature {
            #[cfg(feature = "second-order")]
            Curvature::Exact => cost.add_exact_expansion(at, factor, out),
            // Without that feature solvers take no exact curvature.
            _ => cost.add_expansion(at, factor, memory, out),
        }
        let mut first = 0;
        for constraint in self.problem.constraints_at(self.stage) {
            let own = multipliers.part(&mut first, constraint.dim());
            constraint.add_penalty(at, &own, memory, out);
        }
    }

    /// The largest violation of a constraint.
    pub(super) fn violation(&self, memory: &mut ResidualJacobian) -> f64 {
        let (at, mut largest) = (self.point(), 0.0_f64);
        for constraint in self.problem.constraints_at(self.stage) {
            largest = largest.max(constraint.largest_excess(at, memory));
        }
        largest
    }

    /// λ ← μ (z − proj z) with z = r + λ/μ.
    pub(super) fn update_multipliers(
        &self,
        lambda: &mut [f64],
        mu: f64,
        memory: &mut ResidualJacobian,
    ) {
        let (at, mut first) = (self.point(), 0);
        for constraint in self.problem.constraints_at(self.stage) {
            let own = &mut lambda[first..first + constraint.dim()];
            first += constraint.dim();
            constraint.update_multipliers(at, mu, own, memory);
        }
    }

    /// Point at which residuals are evaluated.
    fn point(&self) -> Point<'a> {
        let stage = self.problem.stage_of_motion(self.stage);
        Point::new(self.problem.dynamics(), stage, self.x, self.u)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Scalar;
    use crate::tests::{FINITE_DIFFERENCE, ROUNDING};
    use crate::trajopt::{
        Activation, Constraint, Cost, InputError, Node, Problem, Residual, Scratch, StateError,
        System,
    };

    /// Two numbers that an input bends: x⁺ = x, in steps of 0.1 s.
    struct Pair;
    impl System for Pair {
        fn nx(&self) -> usize {
            2
        }
        fn nu(&self) -> usize {
            1
        }
        fn time_step(&self) -> f64 {
            0.1
        }
        fn step<T: Scalar>(&self, x: &[T], _: &[T], _: &mut Scratch, next: &mut [T]) {
            next.copy_from_slice(x);
        }
    }

    /// x₀ x₁ + u, and x₁² − 3 u.
    struct Bent;
    impl Residual for Bent {
        fn dim(&self, _: &Node<'_>) -> usize {
            2
        }
        fn eval<T: Scalar>(&self, _: &Node<'_, T>, x: &[T], u: &[T], r: &mut [T]) {
            r[0] = x[0] * x[1] + u[0];
            r[1] = x[1] * x[1] - u[0] * 3.0;
        }
    }

    /// A stage under an equation, an inequality that is active and one that is not, before which stands a constraint of
    /// another length.
    fn problem() -> Problem {
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
    const AT_MULTIPLIERS: Multipliers<'_> = Multipliers {
        lambda: &LAMBDA,
        mu: MU,
    };
    const AT: [f64; 3] = [0.7, -0.4, 0.25];

    fn point<'a>(problem: &'a Problem, z: &'a [f64; 3]) -> StagePoint<'a> {
        let (x, u) = z.split_at(2);
        StagePoint {
            problem,
            stage: 0,
            x,
            u,
        }
    }

    fn memory(problem: &Problem) -> ResidualJacobian {
        ResidualJacobian::new(problem.dynamics(), problem.largest_dim())
    }

    #[test]
    fn gradient_under_multipliers_equals_finite_differences_of_the_merit() {
        let problem = problem();
        let mut memory = memory(&problem);
        for curvature in [Curvature::GaussNewton, Curvature::Exact] {
            let mut out = Expansion::zeros(3);
            point(&problem, &AT).expand(curvature, &AT_MULTIPLIERS, &mut memory, &mut out);
            for i in 0..3 {
                let mut merit = |step: f64| {
                    let mut z = AT;
                    z[i] += step;
                    let at = point(&problem, &z);
                    at.cost(&mut memory) + at.penalties(&AT_MULTIPLIERS, &mut memory)
                };
                const STEP: f64 = 1e-5;
                let slope = (merit(STEP) - merit(-STEP)) / (2.0 * STEP);
                assert!(
                    (out.gradient[i] - slope).abs() < FINITE_DIFFERENCE,
                    "{curvature:?}, {i}"
                );
                assert!(
                    (out.value - merit(0.0)).abs() < 10.0 * ROUNDING,
                    "{curvature:?}"
                );
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
            assert!((is - expected).abs() < 10.0 * ROUNDING, "{is} {expected}");
        }
        assert!((at.violation(&mut memory) - 0.2).abs() < 10.0 * ROUNDING);
        assert_eq!(no_multipliers(&problem, 0).len(), lambda.len());
        assert!(no_multipliers(&problem, 1).is_empty());
    }
}
