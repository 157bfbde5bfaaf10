//! Exact Jacobians of the simulation step in tangent coordinates, and gradients of steps and rollouts.
//!
//! With x = (q, v) and the step x⁺ = f(x, u), small changes obey  δx⁺ = A δx + B δu  where δx = (δq, δv) ∈ ℝ²ⁿᵛ and q moves as
//! q ⊕ δq. A and B are the Jacobians of the simulated step, including its implicit forces. An Euler step, semi-implicit or implicit in
//! velocity, evaluates the dynamics once, so its Jacobians follow by the implicit function theorem from those of inverse dynamics, of each term of the
//! equation of motion by itself (`sim/terms`), and of the solver of the forces of rows, with each joint's own step (`sim/integrators`). The same
//! Jacobians of the acceleration are those in continuous time (`rate.rs`), and, by the chain rule over four stages, give those of a Runge–Kutta step.
//!
//! | question | function | cost | reference |
//! |---|---|---|---|
//! | A and B of a step? | [`Simulator::linearize`], [`Simulator::linearize_into`] | 3 to 12 steps on the robots that [`autodiff`](crate::autodiff) lists; with the Runge–Kutta method four times that, and products of matrices, O(nv³) | [Carpentier, Mansard 2018] |
//! | with the base velocity in another representation? | [`Linearization::to_representation`] | O(nv²) | |
//! | in continuous time? | [`Simulator::linearize_rate`] | as for a step | |
//! | derivatives of A and B along a direction; several states at once? | the same, on dual numbers or lanes | as for a step there | [Griewank, Walther 2008, chapter 5] |
//! | C and D of the sensor readings? | [`Sensors::linearize`](crate::sim::Sensors::linearize) | those of a step, and the readings alone over dual numbers for every four directions | |
//! | of many states at once? | [`BatchSimulator::linearize`](crate::sim::BatchSimulator::linearize), [`BatchSimulator::vjp`](crate::sim::BatchSimulator::vjp) | the same for each, on all cores | |
//! | Aᵀ λ, Bᵀ λ, and the same in all [parameters](Simulator::parameters)? | [`Simulator::vjp`], [`Simulator::vjp_into`] | three to six steps, independent of the number of parameters | [Griewank, Walther 2008, chapter 3] |
//! | the gradient of a cost of a whole rollout? | [`Simulator::rollout_gradient`], [`Simulator::rollout_gradients`] | four to eight rollouts, up to nine with checkpoints | [Griewank, Walther 2008, chapter 12] |
//! | the product of its Hessian with a direction? | [`Simulator::rollout_hessian_product`] | for each direction a rollout and its gradient over dual numbers, 14 to 32 rollouts (`benches/RESULTS.md`) | [Griewank, Walther 2008, chapter 5] |
//! | check by finite differences, with nonsmooth points? | [`Simulator::estimate_linearization`] | about twenty steps for each direction | [Ridders 1982] |
//! | is the time step short enough? | [`Simulator::remarks`], [`Simulator::remarks_at`] | Jacobians of step and rate with their eigenvalues, O(nv³); about thirty of these if the step is too long | |
//! | why is a derivative zero? | [`Simulator::contact_report`] | that of a step | |

mod batch;
mod differences;
mod rate;
mod remarks;
mod representation;
mod rollout;
mod sensors;
mod vjp;

use nalgebra::DMatrix;

use crate::autodiff::finite_difference::Options;
use crate::dynamics::Calls;
use crate::memory;
use crate::scalar::{Differentiable, Opaque, Scalar, compiled_over_f64};
use crate::sim::{Pushforward, Simulator, State, StepColumns, StepJacobian, StepPoint};
pub use rate::RateScratch;
pub use rollout::{
    Checkpoints, CostScratch, CostSlopes, RolloutCost, RolloutGradient, RolloutGradientOptions,
    StagePoint, WantedParameters,
};
#[cfg(feature = "second-order")]
pub use rollout::{RolloutDirection, RolloutHessianProduct};
pub use sensors::SensorLinearization;
pub use vjp::{StepGradient, VjpScratch};

/// The Jacobians of one step: δx⁺ = A δx + B δu.
///
/// Over a scalar with derivatives, the entries carry their derivatives.
#[derive(Clone, Debug, PartialEq)]
pub struct Linearization<T: Scalar = f64> {
    /// A, square; rows and columns (δq, δv), then the contact state and activations where there are any.
    pub a: DMatrix<T>,
    /// B, `nu` columns, rows as those of A.
    pub b: DMatrix<T>,
}

impl<T: Scalar> Linearization<T> {
    /// Memory for the Jacobians of a simulator.
    ///
    /// # Panics
    /// If they would need more memory than the [limit](crate::memory): bristles of soft contact are three coordinates of the state for each point.
    pub fn zeros(simulator: &Simulator) -> Self {
        let n = simulator.n_tangent();
        let numbers = n.saturating_mul(n.saturating_add(simulator.nu()));
        let what = format_args!("Jacobians of {n} coordinates of the state");
        let bytes = numbers.saturating_mul(size_of::<T>());
        memory::granted(memory::check(what, bytes));
        Self {
            a: DMatrix::zeros(n, n),
            b: DMatrix::zeros(n, simulator.nu()),
        }
    }
}

/// The Jacobians of one step by finite differences, with error estimates.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearizationEstimate {
    /// A and B.
    pub linearization: Linearization,
    /// The estimated error of each entry, not negative; see [`Estimate`](crate::autodiff::finite_difference::Estimate).
    pub error: Linearization,
}

/// Working memory of [`Simulator::linearize_into`]. It belongs to the model that it was made for and to clones of it; after a change of masses,
/// placements or armature a new one is needed.
#[derive(Clone, Debug)]
pub struct LinearizeScratch<T: Differentiable = f64>(Opaque<StepJacobian<T>>);

impl<T: Differentiable> LinearizeScratch<T> {
    /// Makes memory for a simulator.
    pub fn new(simulator: &Simulator) -> Self {
        Self(compiled_over_f64!(
            [f64, T] memory, simulator: &Simulator => Opaque<StepJacobian<f64>> as Opaque<StepJacobian<T>>
        ))
    }
}

fn memory<T: Differentiable>(simulator: &Simulator) -> Opaque<StepJacobian<T>> {
    Opaque::new(StepJacobian::new(simulator, Calls::Many))
}

impl Simulator<f64> {
    /// Computes the Jacobians A and B of the step from `state` with input `u`. Allocates.
    ///
    /// Works for all joint kinds, bases and integrators; exact to rounding. On [`Dual`](crate::autodiff::Dual) or the types of num-dual the result
    /// also carries second derivatives of the step along directions; on [`Lanes`](crate::Lanes) it contains the Jacobians of several states.
    ///
    /// # Impacts
    /// A and B are the Jacobians of the step, not those of the motion in continuous time. In a step with a landing point:
    ///
    /// | contact | meaning of A |
    /// |---|---|
    /// | [`Rigid`](crate::contact::Rigid), an isolated impact with restitution | correct: a motion that starts higher lands later and faster. Computed by rows of gradients, at about `n_tangent` times the cost of [`vjp`](Self::vjp) |
    /// | `Rigid`, several impacts in one step or no restitution | contains the change of velocity in the impact, but not the change of the landing time. In a chain of steps the derivative in the initial position is wrong at any step length |
    /// | [`RelaxedRigid`](crate::contact::RelaxedRigid) | the same if an impact lasts a few steps, as with its defaults: biased |
    /// | [`SoftContact`](crate::contact::SoftContact) with q = 1 + p | correct if the contact lasts about fifty steps; see the table there |
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, State, model::samples};
    ///
    /// let simulator = Simulator::new(samples::pendulum()).with_time_step(0.01);
    /// let step = simulator.linearize(&State::new(&[0.0], &[0.0]), &[0.0]);
    /// // v⁺ = v + Δt (u − ½ g sin q) / J with J = 1/3 kg·m²
    /// assert!((step.b[(1, 0)] - 0.03).abs() < 1e-15);
    /// assert!((step.a[(1, 0)] + 0.01 * 1.5 * 9.81).abs() < 1e-15);
    /// ```
    ///
    /// ```
    /// use dualbody::{Scalar, Simulator, State, autodiff::Dual, model::samples};
    ///
    /// // v⁺ = v − Δt (3 g / 2 l) sin q, so that ∂²v⁺/∂q² = Δt (3 g / 2 l) sin q
    /// let simulator = Simulator::new(samples::pendulum()).with_time_step(0.01);
    /// let state = State::new(&[Dual::<f64, 1>::variable(0.5, 0)], &[Dual::from(0.0)]);
    /// let step = simulator.linearize(&state, &[Dual::from(0.0)]);
    /// assert!((step.a[(1, 0)].eps[0] - 0.01 * 1.5 * 9.81 * 0.5_f64.sin()).abs() < 1e-14);
    /// ```
    ///
    /// # Panics
    /// If state or input have the wrong length; if the scalar has lanes or no values and a solver finds the forces of contact or constraints; if the
    /// scalar itself has second derivatives and a force is given as a [function](crate::sim::ForceFunction), which has no third derivatives.
    pub fn linearize<T: Differentiable>(&self, state: &State<T>, u: &[T]) -> Linearization<T> {
        let mut out = Linearization::zeros(self);
        let mut scratch = LinearizeScratch::new(self);
        self.linearize_into(state, u, &mut scratch, &mut out);
        out
    }

    /// [`linearize`](Self::linearize) without allocation, except the first semi-implicit Euler step with fast rotation, see [`Integrator`](crate::Integrator).
    ///
    /// # Panics
    /// As there, or if scratch or output have the wrong size.
    pub fn linearize_into<T: Differentiable>(
        &self,
        state: &State<T>,
        u: &[T],
        scratch: &mut LinearizeScratch<T>,
        out: &mut Linearization<T>,
    ) {
        let (simulator, memory) = (self, &mut scratch.0);
        compiled_over_f64!(
            [f64, T] Simulator::linearize_with, simulator: &Simulator, state: &State, u: &[f64],
            memory: &mut Opaque<StepJacobian<f64>>, out: &mut Linearization
        );
    }

    fn linearize_with<T: Differentiable>(
        &self,
        state: &State<T>,
        u: &[T],
        memory: &mut Opaque<StepJacobian<T>>,
        out: &mut Linearization<T>,
    ) {
        let method = memory.get_mut();
        self.check_input(u);
        self.check(state);
        assert!(
            method.is_of(self.integrator()),
            "the scratch was made for another integrator than {:?}",
            self.integrator()
        );
        let at = StepPoint {
            state,
            u,
            acceleration: None,
        };
        let Linearization { a, b } = out;
        method.linearize(self, &at, &mut StepColumns { a, b });
    }

    /// Computes the Jacobians by finite differences of the step, with an error estimate for each entry: a check of [`linearize`](Self::linearize). Allocates.
    ///
    /// Difference steps decrease from 1/1024 (rad, m, m/s, N) to nanometres, so that a point that penetrates by a few micrometres does not leave the
    /// ground. At a nonsmooth point, such as the instant of touch-down or slip, both sides have different derivatives: the entry is their mean,
    /// [`linearize`](Self::linearize) gives one of them, and the error is half their difference.
    ///
    /// * `options` – its size of zeros is the scale of all changes of state and input
    ///
    /// # Panics
    /// If state or input have the wrong length.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, State, autodiff::finite_difference::Options, model::samples};
    ///
    /// let simulator = Simulator::new(samples::pendulum()).with_time_step(0.01);
    /// let by_differences = simulator.estimate_linearization(&State::new(&[0.3], &[0.0]), &[0.0], &Options::default());
    /// let (b, error) = (by_differences.linearization.b, by_differences.error.b);
    /// assert!((b[(1, 0)] - 0.03).abs() < 1e-10 && error[(1, 0)] < 1e-9); // Δt / J with J = 1/3 kg·m²
    /// ```
    pub fn estimate_linearization(
        &self,
        state: &State,
        u: &[f64],
        options: &Options,
    ) -> LinearizationEstimate {
        differences::by_finite_differences(self, state, u, options)
    }
}
