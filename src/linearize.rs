//! Exact Jacobians of the simulation step, in tangent coordinates, and gradients of steps and rollouts without them.
//!
//! With x = (q, v) and the step x⁺ = f(x, u), small changes obey  δx⁺ = A δx + B δu  where δx = (δq, δv) ∈ ℝ²ⁿᵛ and q moves as
//! q ⊕ δq. A and B belong to the very step that is simulated, with what is implicit in it. A step of Euler, semi-implicit or implicit in
//! velocity, evaluates the dynamics once, so its Jacobians follow by the implicit function theorem from those of inverse dynamics, of each term of the
//! equation of motion by itself (`sim/terms`), and of the solver of the forces of rows, with each joint's own step (`sim/integrators`). The same
//! Jacobians of the acceleration are those of continuous time (`rate.rs`), and by the chain rule over its four stages those of a step of Runge and
//! Kutta.
//!
//! | question | function | cost | reference |
//! |---|---|---|---|
//! | A and B of a step? | [`Simulator::linearize`], [`Simulator::linearize_into`] | 3 to 12 steps on the robots that [`autodiff`](crate::autodiff) lists; with Runge and Kutta's method four times that, and products of matrices, O(nv³) | [Carpentier, Mansard 2018] |
//! | with the base velocity in another representation? | [`Linearization::to_representation`] | O(nv²) | |
//! | in continuous time? | [`Simulator::linearize_rate`] | as for a step | |
//! | and how these change, along a direction; or of states side by side? | the same, on dual numbers or lanes | as for a step there | [Griewank, Walther 2008, chapter 5] |
//! | C and D of what sensors read in it? | [`Sensors::linearize`](crate::sim::Sensors::linearize) | an acceleration over dual numbers for every four directions | |
//! | of many states at once? | [`BatchSimulator::linearize`](crate::sim::BatchSimulator::linearize), [`BatchSimulator::vjp`](crate::sim::BatchSimulator::vjp) | the same for each, on all cores | |
//! | Aᵀ λ, Bᵀ λ, and the same in all [parameters](Simulator::parameters)? | [`Simulator::vjp`], [`Simulator::vjp_into`] | three to six steps, however many numbers | [Griewank, Walther 2008, chapter 3] |
//! | the gradient of a cost of a whole rollout? | [`Simulator::rollout_gradient`], [`Simulator::rollout_gradients`] | four to seven rollouts, up to nine with checkpoints | [Griewank, Walther 2008, chapter 12] |
//! | the product of its Hessian with a direction? | [`Simulator::rollout_hessian_product`] | for each direction a rollout and its gradient over dual numbers, 14 to 32 rollouts (`benches/RESULTS.md`) | [Griewank, Walther 2008, chapter 5] |
//! | are they right, and is there a kink? | [`Simulator::estimate_linearization`] | some twenty steps for each direction | [Ridders 1982] |
//! | is the time step short enough? | [`Simulator::remarks`], [`Simulator::remarks_at`] | a Jacobian of step and rate with their eigenvalues, O(nv³); where it is not, some thirty | |
//! | why is one zero? | [`Simulator::contact_report`] | that of a step | |

mod batch;
mod differences;
mod rate;
mod remarks;
mod representation;
mod rollout;
mod sensors;
mod vjp;

use std::any::Any;

use nalgebra::DMatrix;

use crate::autodiff::finite_difference::Options;
use crate::dynamics::Calls;
use crate::memory;
use crate::scalar::{Differentiable, Scalar};
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
/// Over a scalar with derivatives, with how they change.
#[derive(Clone, Debug, PartialEq)]
pub struct Linearization<T: Scalar = f64> {
    /// A, square; rows and columns (δq, δv), then the state of contact and activations where there are any.
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

/// The Jacobians of one step by finite differences, and how far they can be trusted.
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
pub struct LinearizeScratch<T: Differentiable = f64> {
    method: StepJacobian<T>,
}

impl<T: Differentiable> LinearizeScratch<T> {
    /// Memory for a simulator.
    pub fn new(simulator: &Simulator) -> Self {
        Self {
            method: StepJacobian::new(simulator, Calls::Many),
        }
    }
}

impl Simulator<f64> {
    /// Computes the Jacobians A and B of the step from `state` with input `u`. Allocates.
    ///
    /// Works for every joint kind, base and integrator; exact to rounding. Over any scalar: on [`Dual`](crate::autodiff::Dual) or the types of num-dual it
    /// has the second derivatives of the step along directions too, on [`Lanes`](crate::Lanes) the Jacobians of several states side by side.
    ///
    /// # Impacts
    /// They are the Jacobians of the step, not those of the motion in continuous time. In a step in which a point lands:
    ///
    /// | contact | A says |
    /// |---|---|
    /// | [`Rigid`](crate::contact::Rigid), an impact by itself with restitution | what happens: that a motion which starts higher lands later, and how fast it lands. Rows of gradients, so some `n_tangent` times the cost of [`vjp`](Self::vjp) |
    /// | `Rigid`, several impacts in one step or no restitution | how the velocity after the impact follows that before it; not that a motion which starts higher lands later. In a chain of steps the derivative in where it starts is wrong, however short they are |
    /// | [`RelaxedRigid`](crate::contact::RelaxedRigid) | the same where an impact lasts a few steps, as with its defaults: biased |
    /// | [`SoftContact`](crate::contact::SoftContact) with q = 1 + p | what happens, if the contact lasts some fifty steps; a table is there |
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
    /// If state or input have the wrong length; over what has lanes or no values, if the forces of contact or constraints are found by a solver; over
    /// what has second derivatives itself, if there is a force given as a [function](crate::sim::ForceFunction), which has no third ones.
    pub fn linearize<T: Differentiable>(&self, state: &State<T>, u: &[T]) -> Linearization<T> {
        let mut out = Linearization::zeros(self);
        let mut scratch = LinearizeScratch::new(self);
        self.linearize_into(state, u, &mut scratch, &mut out);
        out
    }

    /// [`linearize`](Self::linearize) without allocation; with semi-implicit Euler but for the first step in which something whirls, see
    /// [`Integrator`](crate::Integrator).
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
        // A condition that is known when it compiles: programs do not compile again what the library has.
        if T::IS_F64 {
            let (state, scratch, out): (&dyn Any, &mut dyn Any, &mut dyn Any) =
                (state, scratch, out);
            let own = (state.downcast_ref(), scratch.downcast_mut());
            if let ((Some(state), Some(scratch)), Some(u), Some(out)) =
                (own, T::as_f64(u), out.downcast_mut())
            {
                self.linearize_values(state, u, scratch, out);
            }
        } else {
            self.linearize_numbers(state, u, scratch, out);
        }
    }

    /// [`linearize_into`](Self::linearize_into) over `f64`: compiled here, once.
    fn linearize_values(
        &self,
        state: &State,
        u: &[f64],
        scratch: &mut LinearizeScratch,
        out: &mut Linearization,
    ) {
        self.linearize_numbers(state, u, scratch, out);
    }

    fn linearize_numbers<T: Differentiable>(
        &self,
        state: &State<T>,
        u: &[T],
        scratch: &mut LinearizeScratch<T>,
        out: &mut Linearization<T>,
    ) {
        self.check_input(u);
        self.check(state);
        let method = &mut scratch.method;
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

    /// Computes the Jacobians by finite differences of the step, to check against, with an estimate of the error of each entry. Allocates.
    ///
    /// Steps are sought from 1/1024 (rad, m, m/s, N) downward, to nanometres, so that a point that touches the ground by some micrometres
    /// does not leave it. Where it does with any step, as at the very moment of touch-down or of slipping, the two sides have slopes of
    /// their own: the entry is their mean, [`linearize`](Self::linearize) gives one of them, and the error is half their difference.
    ///
    /// * `options` – the size that zeros are taken to have is that of all changes of state and input
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
