//! Activations: what happens to an input before it reaches its motor, with a state of its own.
//!
//! An input u that has an activation arrives after a delay and goes through dynamics with a state w. The motor or the servo gets their signal s in its place,
//! which is held over the step as inputs are:
//!
//! | dynamics | state | signal | state after the step |
//! |---|---|---|---|
//! | delay of n steps | the last n inputs | the input of n steps ago, which is the u of the other rows | shifted by one |
//! | [`filter`](Activation::filter) | w | w | u + (w − u) exp(−Δt/τ) |
//! | [`explicit_filter`](Activation::explicit_filter) | w | w | w + Δt (u − w)/τ |
//! | [`integrator`](Activation::integrator) | w | w | w + Δt u |
//! | [`function`](Activation::function), such as an [`ActuatorNetwork`] | any numbers | any function of u, w, q, v | any function of them |
//!
//! The states are part of [`State`](super::State), and of A and B: an activation is stated here once, over the scalar, and `integrators/activated.rs` puts it before any
//! method.

mod function;
mod network;
mod placed;

use super::actuation::Interval;
use crate::numbers::{Numbers, numbers};
use crate::scalar::{Over, Scalar};
use function::Function;
pub use function::{ActuatorFunction, ActuatorPoint, MAX_ACTUATOR_PARAMETERS, MAX_ACTUATOR_STATES};
pub use network::ActuatorNetwork;
pub(crate) use placed::{JointCoordinate, PlacedActivation, Variable};

/// Delay and dynamics between an input and its motor or servo, for [`Simulator::with_activation`](super::Simulator::with_activation).
///
/// # Examples
/// ```
/// use dualbody::{Simulator, model::samples, sim::Activation};
///
/// // A motor whose torque follows its input by a first-order lag of 20 ms
/// let simulator = Simulator::new(samples::pendulum()).with_time_step(0.01);
/// let simulator = simulator.with_activation("pivot", Activation::filter(0.02))?;
/// let start = simulator.state(&[0.0], &[0.0]);
/// let next = simulator.step(&start, &[1.0]);
/// assert_eq!(next.v[0], 0.0); // the torque is 0 until the step has ended
/// assert!((next.activation[0] - (1.0 - f64::exp(-0.5))).abs() < 1e-15);
/// assert_eq!(simulator.linearize(&start, &[1.0]).a.nrows(), 3);
/// # Ok::<(), dualbody::UnknownName>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Activation<P = f64> {
    /// Steps.
    delay: usize,
    input_range: Option<Interval<P>>,
    dynamics: Dynamics<P>,
    range: Option<Interval<P>>,
    is_early: bool,
}

/// Dynamics after the delay.
#[derive(Clone, Debug, PartialEq)]
enum Dynamics<P> {
    Nothing,
    Filter { time_constant: P },
    ExplicitFilter { time_constant: P },
    Integrator,
    Function(Function<P>),
}

numbers! { pub struct Activation {
    delay: kept(),
    input_range: part(Interval, "{} input", "{} input of an activation"),
    dynamics: part(Dynamics),
    range: part(Interval, "{} activation", "{} activation"),
    is_early: kept(),
} }

numbers! { enum Dynamics {
    Nothing {},
    Filter { time_constant: Positive("time constant", "time constant of an activation") },
    ExplicitFilter { time_constant: Positive("time constant", "time constant of an activation") },
    Integrator {},
    Function(function: part(Function)),
} }

/// The most steps of a delay.
const MOST_DELAY: usize = 100_000;

impl Activation<f64> {
    fn of(dynamics: Dynamics<f64>) -> Self {
        let own = Self {
            delay: 0,
            input_range: None,
            dynamics,
            range: None,
            is_early: false,
        };
        own.check();
        own
    }

    /// A delay alone.
    ///
    /// * `steps` – number of time steps
    ///
    /// # Panics
    /// If there are more than 100 000.
    pub fn delay(steps: usize) -> Self {
        Self::of(Dynamics::Nothing).with_delay(steps)
    }

    /// A first-order lag,  ẇ = (u − w)/τ,  solved exactly over each step: stable for every time constant.
    ///
    /// * `time_constant` – τ, s
    ///
    /// # Panics
    /// If it is not positive and finite.
    pub fn filter(time_constant: f64) -> Self {
        Self::of(Dynamics::Filter { time_constant })
    }

    /// A first-order lag by Euler's explicit method, which other engines use: unstable for steps beyond 2 τ.
    ///
    /// * `time_constant` – τ, s
    ///
    /// # Panics
    /// If it is not positive and finite.
    pub fn explicit_filter(time_constant: f64) -> Self {
        Self::of(Dynamics::ExplicitFilter { time_constant })
    }

    /// The integral of the input,  ẇ = u: before a position servo, an integrated velocity. Without a [range](Self::with_range) it winds up.
    pub fn integrator() -> Self {
        Self::of(Dynamics::Integrator)
    }

    /// A user-defined actuator: signal and next state as a function of the state, the input and the motion of the joint.
    ///
    /// * `parameters` – passed to the function; they are [parameters](super::Simulator::parameters) of the simulator
    ///
    /// # Panics
    /// If there are more than [`MAX_ACTUATOR_PARAMETERS`] parameters, one is not finite, or the function has more than [`MAX_ACTUATOR_STATES`] state variables.
    pub fn function(function: impl ActuatorFunction, parameters: &[f64]) -> Self {
        Self::of(Dynamics::Function(Function::new(function, parameters)))
    }

    /// Adds a delay before the activation: it receives the input of `steps` steps ago, initially 0.
    ///
    /// * `steps` – number of time steps
    ///
    /// # Panics
    /// If there are more than 100 000.
    #[must_use]
    pub fn with_delay(self, steps: usize) -> Self {
        let own = Self {
            delay: steps,
            ..self
        };
        own.check();
        own
    }

    /// Clamps the input of the dynamics to a range.
    ///
    /// # Panics
    /// If an end is not finite, or the lower end is above the upper end.
    #[must_use]
    pub fn with_input_range(self, lower: f64, upper: f64) -> Self {
        let own = Self {
            input_range: Some(Interval { lower, upper }),
            ..self
        };
        own.check();
        own
    }

    /// Clamps the state of a filter or an integrator to a range after each step.
    ///
    /// # Panics
    /// If an end is not finite, or the lower end is above the upper end.
    #[must_use]
    pub fn with_range(self, lower: f64, upper: f64) -> Self {
        let own = Self {
            range: Some(Interval { lower, upper }),
            ..self
        };
        own.check();
        own
    }

    /// The activation with ranges where there are any.
    pub(crate) fn with_ranges(self, input: Option<Interval>, state: Option<Interval>) -> Self {
        let own = Self {
            input_range: input,
            range: state,
            ..self
        };
        own.check();
        own
    }

    /// The activation whose signal is the state of a filter or an integrator after the step, so that the input acts in the same step.
    #[must_use]
    pub fn early(self) -> Self {
        Self {
            is_early: true,
            ..self
        }
    }
}

/// Arguments of an activation: the input after its delay, and the motion of its joint.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arguments<L> {
    pub(crate) u: L,
    pub(crate) q: L,
    pub(crate) v: L,
}

impl<P: Scalar> Activation<P> {
    /// # Panics
    /// If a parameter is outside of its domain; the message names it.
    pub(crate) fn check(&self) {
        self.check_numbers();
        assert!(
            self.delay <= MOST_DELAY,
            "a delay of {} steps, at most {MOST_DELAY} are possible",
            self.delay
        );
        for (range, of) in [
            (&self.input_range, "inputs of an activation"),
            (&self.range, "numbers of an activation"),
        ] {
            if let Some(range) = range {
                range.check_order(of);
            }
        }
    }

    /// Whether it needs position and velocity of a joint.
    pub(crate) fn needs_motion(&self) -> bool {
        matches!(self.dynamics, Dynamics::Function(_))
    }

    /// Steps by which the input arrives late.
    pub(crate) fn delay_steps(&self) -> usize {
        self.delay
    }

    /// Numbers of state of the dynamics after the delay.
    fn dynamic_states(&self) -> usize {
        match &self.dynamics {
            Dynamics::Nothing => 0,
            Dynamics::Filter { .. } | Dynamics::ExplicitFilter { .. } | Dynamics::Integrator => 1,
            Dynamics::Function(function) => function.states(),
        }
    }

    /// Numbers of state.
    pub(crate) fn states(&self) -> usize {
        self.delay + self.dynamic_states()
    }

    /// The signal over a step, and the state of the dynamics after it.
    ///
    /// * `dt` – s
    /// * `w` – state of the dynamics
    /// * `next` – output, that after the step
    pub(crate) fn respond<L: Over<P>>(
        &self,
        at: &Arguments<L>,
        dt: P,
        w: &[L],
        next: &mut [L],
    ) -> L {
        let range = self.input_range.as_ref();
        let u = range.map_or(at.u, |range| range.lift().nearest(at.u));
        let stepped = match &self.dynamics {
            Dynamics::Nothing => return u,
            Dynamics::Function(function) => {
                return function.respond(&Arguments { u, ..*at }, dt, w, next);
            }
            // w⁺ = u + (w − u) exp(−Δt/τ)
            Dynamics::Filter { time_constant } => u + (w[0] - u) * (-dt / *time_constant).exp(),
            Dynamics::ExplicitFilter { time_constant } => w[0] + (u - w[0]) * (dt / *time_constant),
            Dynamics::Integrator => w[0] + u * dt,
        };
        let range = self.range.as_ref();
        next[0] = range.map_or(stepped, |range| range.lift().nearest(stepped));
        if self.is_early { next[0] } else { w[0] }
    }
}
