//! The rollout forward, its gradient and its Hessian backward.
//!
//! With  Aₖ, Bₖ  the step Jacobians and  l  the costs of the stages (penalties included):
//!
//! ```text
//!   λ_N = ∂l_N/∂x,   λₖ = ∂lₖ/∂x + Aₖᵀ λₖ₊₁,   dJ/duₖ = ∂lₖ/∂u + Bₖᵀ λₖ₊₁,   dJ/dx₀ = λ₀
//! ```
//!
//! and the same once more for the derivative of all this in a direction (δx₀, δu), which is a column of the Hessian:
//!
//! ```text
//!   δxₖ₊₁ = Aₖ δxₖ + Bₖ δuₖ,   δλₖ = Wₓₓ δxₖ + Wₓᵤ δuₖ + Aₖᵀ δλₖ₊₁,   δ(dJ/duₖ) = Wᵤₓ δxₖ + Wᵤᵤ δuₖ + Bₖᵀ δλₖ₊₁
//! ```
//!
//! where W is the Hessian of lₖ alone (Gauss–Newton), or of  lₖ + λₖ₊₁ᵀ fₖ  (exact).

use nalgebra::{DMatrix, DVector};

use super::lambdas::Lambdas;
use crate::autodiff::{CHUNK, Dual, TangentPoint};
use crate::linearize::Linearization;
use crate::trajopt::constraint::Multipliers;
use crate::trajopt::cost::Expansion;
use crate::trajopt::curvature::Curvature;
use crate::trajopt::problem::Problem;
use crate::trajopt::residual::ResidualJacobian;
use crate::trajopt::scratch::Scratch;
use crate::trajopt::system::{AnySystem, Manifold, zero_linearization};
use crate::trajopt::trajectory::Trajectory;

/// A trajectory that satisfies the dynamics, with its evaluations; the caller tracks which are valid.
pub(super) struct Sweep {
    pub(super) trajectory: Trajectory,
    scratch: Scratch,
    memory: ResidualJacobian,
    steps: Vec<Linearization>,
    stages: Vec<Expansion>,
    /// λ₀ … `λ_N`, each of length `ndx`.
    adjoints: Vec<DVector<f64>>,
}

/// Source of Aᵀ λ and Bᵀ λ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Transposed {
    /// The Jacobians that [`Sweep::linearize`] left.
    Jacobians,
    /// Vector-Jacobian products of the steps.
    Products,
}

/// A gradient, or a column of a Hessian, in x₀ and in the input of each stage.
pub(super) struct Gradient {
    pub(super) start: DVector<f64>,
    pub(super) inputs: Vec<DVector<f64>>,
}

impl Sweep {
    pub(super) fn new(problem: &Problem) -> Self {
        let (system, n) = (problem.dynamics(), problem.horizon());
        let (ndx, nu) = (system.ndx(), system.nu());
        let nz = |k| if k == n { ndx } else { ndx + nu };
        Self {
            trajectory: Trajectory::zero_input(problem),
            scratch: Scratch::new(),
            memory: ResidualJacobian::new(system, problem.largest_dim()),
            steps: vec![zero_linearization(system); n],
            stages: (0..=n).map(|k| Expansion::zeros(nz(k))).collect(),
            adjoints: vec![DVector::zeros(ndx); n + 1],
        }
    }

    /// The states that follow from the first one and the inputs of the trajectory.
    pub(super) fn roll(&mut self, system: &dyn AnySystem) {
        let Trajectory { states, inputs } = &mut self.trajectory;
        for (k, u) in inputs.iter().enumerate() {
            let (before, after) = states.split_at_mut(k + 1);
            let (x, next) = (before[k].as_slice(), after[0].as_mut_slice());
            system.step(x, u.as_slice(), &mut self.scratch, next);
        }
    }

    /// Costs and penalties of the trajectory.
    pub(super) fn merit(&mut self, problem: &Problem, at: &Lambdas) -> f64 {
        let memory = &mut self.memory;
        let of_stage = |(stage, lambda): (usize, &Vec<f64>)| {
            let point = self.trajectory.stage(problem, stage);
            let multipliers = Multipliers { lambda, mu: at.mu };
            point.cost(memory) + point.penalties(&multipliers, memory)
        };
        at.lambda.iter().enumerate().map(of_stage).sum()
    }

    /// λ from the violations.
    pub(super) fn update_multipliers(&mut self, problem: &Problem, at: &mut Lambdas) {
        for (stage, lambda) in at.lambda.iter_mut().enumerate() {
            let point = self.trajectory.stage(problem, stage);
            point.update_multipliers(lambda, at.mu, &mut self.memory);
        }
    }

    /// Costs to second order.
    pub(super) fn expand_costs(&mut self, problem: &Problem, at: &Lambdas, curvature: Curvature) {
        for (stage, out) in self.stages.iter_mut().enumerate() {
            let point = self.trajectory.stage(problem, stage);
            let multipliers = Multipliers {
                lambda: &at.lambda[stage],
                mu: at.mu,
            };
            point.expand(curvature, &multipliers, &mut self.memory, out);
        }
    }

    /// Jacobians of all steps.
    pub(super) fn linearize(&mut self, problem: &Problem) {
        for (stage, step) in self.steps.iter_mut().enumerate() {
            let point = self.trajectory.stage(problem, stage);
            let scratch = &mut self.scratch;
            problem
                .dynamics()
                .linearize(point.x, point.u, scratch, step);
        }
    }

    /// The gradient, from what [`expand_costs`](Self::expand_costs) left.
    pub(super) fn gradient(&mut self, problem: &Problem, by: Transposed) -> Gradient {
        let (n, system) = (self.steps.len(), problem.dynamics());
        let mut inputs = vec![DVector::zeros(system.nu()); n];
        self.adjoints[n].copy_from(&self.stages[n].gradient);
        for k in (0..n).rev() {
            let (here, after) = self.adjoints.split_at_mut(k + 1);
            let (dx, du, lambda) = (&mut here[k], &mut inputs[k], &after[0]);
            if by == Transposed::Jacobians {
                dx.gemv_tr(1.0, &self.steps[k].a, lambda, 0.0);
                du.gemv_tr(1.0, &self.steps[k].b, lambda, 0.0);
            } else {
                let point = self.trajectory.stage(problem, k);
                let (dx, du) = (dx.as_mut_slice(), du.as_mut_slice());
                let (lambda, scratch) = (lambda.as_slice(), &mut self.scratch);
                system.vjp(point.x, point.u, lambda, scratch, dx, du);
            }
            let costs = &self.stages[k].gradient;
            *dx += costs.rows(0, dx.len());
            *du += costs.rows(dx.len(), du.len());
        }
        Gradient {
            start: self.adjoints[0].clone(),
            inputs,
        }
    }

    /// Makes the Hessians of the stages those of  lₖ + λₖ₊₁ᵀ fₖ  where that is requested, and whole; after
    /// [`gradient`](Self::gradient), and once.
    pub(super) fn complete_hessians(&mut self, problem: &Problem, curvature: Curvature) {
        if curvature == Curvature::Exact {
            for k in 0..self.steps.len() {
                let hessian = self.stages[k].hessian.as_mut_slice();
                let adjoint = self.adjoints[k + 1].as_slice();
                let (x, u) = (
                    self.trajectory.states[k].as_slice(),
                    self.trajectory.input(k),
                );
                problem.dynamics().add_step_hessian(x, u, adjoint, hessian);
            }
        }
        self.stages.iter_mut().for_each(Expansion::mirror);
    }

    /// The derivative of the gradient in a direction: of x₀, or of one input of one stage.
    pub(super) fn hessian_column(&self, variation: Variation<'_>) -> Gradient {
        let n = self.steps.len();
        let ndx = self.stages[n].gradient.len();
        let dz = self.sensitivities(variation);
        let mut inputs = vec![DVector::zeros(0); n];
        let mut adjoint = &self.stages[n].hessian * &dz[n];
        for k in (0..n).rev() {
            let step = &self.steps[k];
            let own = &self.stages[k].hessian * &dz[k];
            inputs[k] = own.rows(ndx, own.len() - ndx) + step.b.tr_mul(&adjoint);
            adjoint = own.rows(0, ndx) + step.a.tr_mul(&adjoint);
        }
        Gradient {
            start: adjoint,
            inputs,
        }
    }

    /// (δxₖ, δuₖ) of all stages.
    fn sensitivities(&self, variation: Variation<'_>) -> Vec<DVector<f64>> {
        let zeros = |stage: &Expansion| DVector::zeros(stage.gradient.len());
        let mut dz: Vec<_> = self.stages.iter().map(zeros).collect();
        let ndx = self.stages[self.steps.len()].gradient.len();
        match variation {
            Variation::Start(dx) => dz[0].as_mut_slice()[..ndx].copy_from_slice(dx),
            Variation::Input { stage, entry, rate } => dz[stage][ndx + entry] = rate,
        }
        for (k, step) in self.steps.iter().enumerate() {
            let moved = &step.a * dz[k].rows(0, ndx) + &step.b * dz[k].rows(ndx, step.b.ncols());
            dz[k + 1].rows_mut(0, ndx).copy_from(&moved);
        }
        dz
    }
}

/// Variation of the first state or of an input, of which a sensitivity is found.
#[derive(Clone, Copy, Debug)]
pub(super) enum Variation<'a> {
    /// The first state, by this δx₀.
    Start(&'a [f64]),
    /// An entry of the input of a stage, at this rate.
    Input {
        stage: usize,
        entry: usize,
        rate: f64,
    },
}

/// ∂((start ⊕ (δ + ε)) ⊖ (start ⊕ δ))/∂ε at zero: how x₀ moves with the variables δ of a free start. No columns without
/// any.
pub(super) fn start_jacobian(system: &dyn AnySystem, start: &[f64], delta: &[f64]) -> DMatrix<f64> {
    let ndx = system.ndx();
    if system.is_vector_space() || delta.is_empty() {
        return DMatrix::identity(ndx, delta.len());
    }
    let mut moved = start.to_vec();
    system.integrate(start, delta, moved.as_mut_slice());
    let lift = |x: &f64| Dual::from(*x);
    let base: Vec<_> = moved.iter().map(lift).collect();
    let mut point = TangentPoint::<Dual<f64, CHUNK>>::new(start.len(), ndx, 0);
    point.set_to(start.iter().map(lift), delta.iter().map(lift));
    let dual: &dyn Manifold<Dual<f64, CHUNK>> = system;
    let mut out = DMatrix::zeros(ndx, ndx);
    point.jacobian_into(
        |x, dx, out| dual.integrate(x, dx, out),
        |x, _, change| dual.difference(&base, x, change),
        &mut vec![Dual::from(0.0); ndx],
        &mut out,
    );
    out
}

#[cfg(test)]
mod tests {
    use crate::tests::SAME_ALGEBRA;
    use crate::trajopt::SingleShooting;
    use crate::trajopt::tests::{A, B, LAST, Q, R, START, linear_quadratic};

    // With xₖ = aᵏ x₀ + Σᵢ aᵏ⁻¹⁻ⁱ b uᵢ:  ∂J/∂uᵢ = R uᵢ + Σₖ qₖ xₖ aᵏ⁻¹⁻ⁱ b  and  ∂²J/∂uᵢ∂uⱼ = R δᵢⱼ + Σₖ qₖ a²ᵏ⁻²⁻ⁱ⁻ʲ
    // b².
    #[test]
    fn gradient_and_hessian_of_a_linear_quadratic_rollout_equal_their_sums() {
        const N: usize = 4;
        let problem = linear_quadratic(N);
        let shooting = SingleShooting::new(&problem);
        let u = [0.3, -1.2, 0.7, 0.1];
        let power = |k: usize, i: usize| {
            if k > i {
                A.powi((k - 1 - i) as i32) * B
            } else {
                0.0
            }
        };
        let x = |k: usize| {
            let pushed: f64 = (0..N).map(|i| power(k, i) * u[i]).sum();
            A.powi(k as i32) * START + pushed
        };
        let weight = |k: usize| if k == N { LAST } else { Q };
        let (gradient, hessian) = (shooting.gradient(&u), shooting.hessian(&u));
        for i in 0..N {
            let slope: f64 = (1..=N).map(|k| weight(k) * x(k) * power(k, i)).sum();
            assert!(
                (gradient[i] - (R * u[i] + slope)).abs() < SAME_ALGEBRA,
                "{i}"
            );
            for j in 0..N {
                let sum: f64 = (1..=N).map(|k| weight(k) * power(k, i) * power(k, j)).sum();
                let expected = sum + if i == j { R } else { 0.0 };
                assert!(
                    (hessian[(i, j)] - expected).abs() < SAME_ALGEBRA,
                    "({i}, {j})"
                );
            }
        }
    }
}
