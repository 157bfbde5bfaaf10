//! Gradients of rollouts: of a cost of the trajectory in its start, its inputs and the robot's parameters.
//!
//! With the weights λₙ = ∂l/∂xₙ of the last state, the steps compute, from the last to the first,
//!
//! > λₖ = ∂lₖ/∂xₖ + Aₖᵀ λₖ₊₁,   dJ/duₖ = ∂lₖ/∂uₖ + Bₖᵀ λₖ₊₁,   dJ/dθ = Σₖ (∂xₖ₊₁/∂θ)ᵀ λₖ₊₁,
//!
//! the [vector-Jacobian products](Simulator::vjp) of the steps. The backward pass needs the states of the trajectory: all are stored, or some, from
//! which the others are recomputed ([`Checkpoints`]).

mod cost;
#[cfg(feature = "second-order")]
mod directed;
#[cfg(feature = "second-order")]
mod direction;
#[cfg(feature = "second-order")]
mod hessian;
#[cfg(feature = "second-order")]
mod second_costs;
mod trajectory;

use nalgebra::DVector;

pub use cost::{CostScratch, CostSlopes, RolloutCost, StagePoint};
use cost::{Costs, Stages};
#[cfg(feature = "second-order")]
pub use direction::RolloutDirection;
#[cfg(feature = "second-order")]
pub use hessian::RolloutHessianProduct;
use trajectory::Trajectory;

use super::vjp::{StepGradient, VjpScratch};
use crate::parallel::for_each_part;
use crate::sim::{RolloutStatus, Simulator, State};

/// States of a rollout that are stored for its backward pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Checkpoints {
    /// All: memory grows with the number of steps, and no step is computed twice.
    #[default]
    All,
    /// The square root of the number of steps; nearly all steps are computed twice.
    SquareRoot,
    /// One in this number of steps, at least 1; nearly all steps are computed twice.
    Every(usize),
}

impl Checkpoints {
    /// Number of steps from one state that is kept to the next.
    fn interval(self, steps: usize) -> usize {
        match self {
            Self::All => steps,
            Self::SquareRoot => steps.isqrt(),
            Self::Every(interval) => interval,
        }
        .max(1)
    }
}

/// Parameters of a gradient.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WantedParameters {
    /// None.
    None,
    /// Those of the [model](crate::Model::parameters).
    Model,
    /// All of the [simulator](Simulator::parameters).
    #[default]
    All,
}

/// Options of a rollout gradient: its parameters and checkpoints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RolloutGradientOptions {
    /// States that are stored; all by default.
    pub checkpoints: Checkpoints,
    /// Parameters of the gradient; all by default.
    pub parameters: WantedParameters,
}

impl Default for RolloutGradientOptions {
    fn default() -> Self {
        Self {
            checkpoints: Checkpoints::All,
            parameters: WantedParameters::All,
        }
    }
}

/// A cost of a rollout with its gradient.
#[derive(Clone, Debug, PartialEq)]
pub struct RolloutGradient {
    /// The cost; infinite if the rollout did not complete.
    pub cost: f64,
    /// In the start, along its tangent (δq, δv, and the contact state where there is one), length [`Simulator::n_tangent`].
    pub start: DVector<f64>,
    /// In the input of each step, length `nu` each.
    pub inputs: Vec<DVector<f64>>,
    /// In the [parameters](Simulator::parameters) of the simulator that are [wanted](RolloutGradientOptions::parameters), in their order, which
    /// begins with those of the model.
    pub parameters: DVector<f64>,
    /// The last state.
    pub last: State,
    /// Status of the rollout; unless it is completed, the gradient is zero.
    pub status: RolloutStatus,
}

impl Simulator<f64> {
    /// Computes a cost of the rollout from `start` under `inputs` and its gradient in the start, all inputs and all
    /// [parameters](Self::parameters). Allocates.
    ///
    /// J = Σₖ lₖ(xₖ, uₖ) + l(xₙ). Exact to rounding. It costs four rollouts (an arm of seven joints) to seven (the same on a rod, `cargo bench
    /// --features full --bench gradients`), independent of the number of inputs and parameters. [`rollout_gradients`](Self::rollout_gradients)
    /// selects parameters and checkpoints. Use it also for derivatives in few parameters: dual numbers cost more, even for a single one
    /// (`benches/RESULTS.md`).
    ///
    /// # Impacts
    /// The gradient is that of the discrete steps. Through an isolated impact of [`Rigid`](crate::contact::Rigid) contact with restitution, it equals
    /// that of the motion: the height of a ball after a bounce has the derivative −e in the height from which it comes at a constant speed. Through
    /// other impacts of rigid contact it is wrong at any step length, and through [`RelaxedRigid`](crate::contact::RelaxedRigid) contact it is
    /// biased. Through [`SoftContact`](crate::contact::SoftContact) with q = 1 + p it is within 2 % if the contact lasts twenty steps, and within 0.2
    /// % at fifty. See [`linearize`](Self::linearize).
    ///
    /// * `start` – the first state
    /// * `inputs` – the input of each step, length `nu` (N·m or N)
    ///
    /// # Panics
    /// If start or an input has the wrong length.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Scalar, Simulator, State, linearize::RolloutCost, model::samples};
    /// use nalgebra::DVector;
    ///
    /// /// Square of the angle at the end.
    /// struct Angle;
    /// impl RolloutCost for Angle {
    ///     fn end<T: Scalar>(&self, last: &State<T>) -> T {
    ///         last.q[0] * last.q[0]
    ///     }
    /// }
    /// // Without gravity q = q₀ + v₀ t, here with t = 0.5 s: J = (0.1 + 0.5 · 2)²
    /// let model = samples::pendulum().with_gravity(nalgebra::Vector3::zeros());
    /// let simulator = Simulator::new(model).with_time_step(0.01);
    /// let swing = simulator.rollout_gradient(&State::new(&[0.1], &[2.0]), &vec![DVector::zeros(1); 50], &Angle);
    /// assert!((swing.cost - 1.21).abs() < 1e-12);
    /// assert!((swing.start[0] - 2.2).abs() < 1e-12 && (swing.start[1] - 1.1).abs() < 1e-12);
    /// ```
    ///
    /// # References
    /// [Griewank, Walther 2008, chapters 3 and 12].
    pub fn rollout_gradient<C: RolloutCost>(
        &self,
        start: &State,
        inputs: &[DVector<f64>],
        cost: &C,
    ) -> RolloutGradient {
        let mut memory = RolloutMemory::new(self, &RolloutGradientOptions::default());
        memory.gradient(self, start, inputs, &mut Stages::new(cost, self))
    }

    /// Computes [`rollout_gradient`](Self::rollout_gradient) for one or many rollouts, on all cores, with options.
    ///
    /// * `starts` – the first state of each
    /// * `inputs` – the inputs of each, step by step
    ///
    /// # Panics
    /// As there, or if the numbers of starts and of sequences of inputs differ.
    pub fn rollout_gradients<C: RolloutCost + Sync>(
        &self,
        starts: &[State],
        inputs: &[impl AsRef<[DVector<f64>]> + Sync],
        cost: &C,
        options: &RolloutGradientOptions,
    ) -> Vec<RolloutGradient> {
        let (n, given) = (starts.len(), inputs.len());
        assert_eq!(n, given, "{n} starts with {given} sequences of inputs");
        let mut out = vec![None; n];
        let threads = crate::parallel::available_threads().min(n).max(1);
        let worker = || (RolloutMemory::new(self, options), Stages::new(cost, self));
        let mut workers: Vec<_> = (0..threads).map(|_| worker()).collect();
        for_each_part(&mut workers, &mut out, |(memory, costs), k, out| {
            *out = Some(memory.gradient(self, &starts[k], inputs[k].as_ref(), costs));
        });
        out.into_iter().flatten().collect()
    }
}

/// Working memory of gradients of rollouts.
struct RolloutMemory {
    options: RolloutGradientOptions,
    vjp: VjpScratch,
    step: StepGradient,
    adjoint: DVector<f64>,
    trajectory: Trajectory,
}

impl RolloutMemory {
    fn new(simulator: &Simulator, options: &RolloutGradientOptions) -> Self {
        let step = StepGradient::zeros(simulator);
        let step = match options.parameters {
            WantedParameters::None => step.without_parameters(),
            WantedParameters::Model => step.with_model_parameters_only(simulator),
            WantedParameters::All => step,
        };
        Self {
            options: *options,
            vjp: VjpScratch::new(simulator),
            step,
            adjoint: DVector::zeros(simulator.n_tangent()),
            trajectory: Trajectory::new(simulator),
        }
    }

    fn gradient(
        &mut self,
        simulator: &Simulator,
        start: &State,
        inputs: &[DVector<f64>],
        costs: &mut dyn Costs,
    ) -> RolloutGradient {
        simulator.check(start);
        inputs
            .iter()
            .for_each(|u| simulator.check_input(u.as_slice()));
        let interval = self.options.checkpoints.interval(inputs.len());
        let status = self.trajectory.roll(simulator, start, inputs, interval);
        let mut out = RolloutGradient {
            cost: f64::INFINITY,
            start: DVector::zeros(simulator.n_tangent()),
            inputs: vec![DVector::zeros(simulator.nu()); inputs.len()],
            parameters: DVector::zeros(self.step.parameters.len()),
            last: self.trajectory.last().clone(),
            status,
        };
        if status == RolloutStatus::Completed {
            self.sweep(simulator, inputs, costs, &mut out);
        }
        out
    }

    /// From the last state to the first.
    fn sweep(
        &mut self,
        simulator: &Simulator,
        inputs: &[DVector<f64>],
        costs: &mut dyn Costs,
        out: &mut RolloutGradient,
    ) {
        self.adjoint.fill(0.0);
        self.step.parameters.fill(0.0);
        out.cost = costs.end(simulator, &out.last, self.adjoint.as_mut_slice());
        for k in (0..inputs.len()).rev() {
            self.trajectory.find(simulator, inputs, k);
            let (u, adjoint) = (inputs[k].as_slice(), self.adjoint.as_slice());
            let taken = self.trajectory.at(k, u);
            simulator.add_vjp(&taken, adjoint, &mut self.vjp, &mut self.step);
            std::mem::swap(&mut self.adjoint, &mut self.step.state);
            out.inputs[k].copy_from(&self.step.input);
            let at = StagePoint {
                simulator,
                step: k,
                state: taken.state,
                u,
            };
            let mut slopes = CostSlopes {
                state: self.adjoint.as_mut_slice(),
                input: out.inputs[k].as_mut_slice(),
            };
            out.cost += costs.stage(&at, &mut slopes);
        }
        out.start.copy_from(&self.adjoint);
        out.parameters.copy_from(&self.step.parameters);
    }
}
