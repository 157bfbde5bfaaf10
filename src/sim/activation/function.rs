//! Users' own actuators.

use std::fmt;
use std::sync::Arc;

use super::Arguments;
use crate::numbers::numbers;
use crate::scalar::{CHUNK, Over, Scalar};
use crate::sim::user_function::{Erased, NumberFunction, erase, evaluate};

/// A user-defined actuator, such as a learned one, written over the scalar.
///
/// # Examples
/// ```
/// use dualbody::{Scalar, Simulator, model::samples, sim::{Activation, ActuatorFunction, ActuatorPoint}};
///
/// /// A motor with the torque constant k (N·m/A), the resistance R (Ω) and the inductance L (H), under a voltage u:  L dI/dt = u − R I − k v,  τ = k I.
/// struct Motor;
/// impl ActuatorFunction for Motor {
///     fn states(&self) -> usize {
///         1
///     }
///
///     fn respond<T: Scalar>(&self, at: &ActuatorPoint<T>, state: &[T], parameters: &[T], next: &mut [T]) -> T {
///         let (k, resistance, inductance) = (parameters[0], parameters[1], parameters[2]);
///         // Implicit in the current
///         next[0] = (state[0] + at.dt * (at.u - k * at.v) / inductance) / (at.dt * resistance / inductance + 1.0);
///         k * next[0]
///     }
/// }
/// let simulator = Simulator::new(samples::pendulum()).with_time_step(0.01);
/// let motor = Activation::function(Motor, &[0.5, 2.0, 0.01]);
/// let driven = simulator.with_activation("pivot", motor)?;
/// let start = driven.state(&[0.0], &[0.0]);
/// let step = driven.linearize(&start, &[1.0]);
/// // I⁺ = (Δt/L) u / (1 + Δt R/L) = u/3, and v⁺ = 3 Δt k I⁺
/// assert!((step.b[(2, 0)] - 1.0 / 3.0).abs() < 1e-14 && (step.b[(1, 0)] - 0.03 * 0.5 / 3.0).abs() < 1e-14);
/// # Ok::<(), dualbody::UnknownName>(())
/// ```
///
/// # Limitations
/// First and second derivatives only: third ones panic with a message that says so. A [`Traced`](crate::scalar::Traced) number records what the
/// function does, with all derivatives.
pub trait ActuatorFunction: Send + Sync + 'static {
    /// Numbers of state, which start at 0; at most [`MAX_ACTUATOR_STATES`].
    fn states(&self) -> usize;

    /// The signal over a step: what the motor or the servo of the joint gets as its input. Without a servo it is a force, N·m or N.
    ///
    /// * `at` – the start of the step
    /// * `state` – as many numbers as [`states`](Self::states) says
    /// * `parameters` – those that the activation was made with
    /// * `next` – output, the state after the step; zero as it comes
    fn respond<T: Scalar>(
        &self,
        at: &ActuatorPoint<T>,
        state: &[T],
        parameters: &[T],
        next: &mut [T],
    ) -> T;
}

/// Arguments of an [`ActuatorFunction`].
#[derive(Clone, Copy, Debug)]
pub struct ActuatorPoint<T> {
    /// The input, after its delay and within its range.
    pub u: T,
    /// Position of the joint, rad or m.
    pub q: T,
    /// Velocity of the joint, rad/s or m/s.
    pub v: T,
    /// Time step, s.
    pub dt: T,
}

/// Maximum number of state variables of an actuator function.
pub const MAX_ACTUATOR_STATES: usize = 32;

/// Maximum number of parameters of an actuator function. Weights of a network are fields of the function instead.
pub const MAX_ACTUATOR_PARAMETERS: usize = 8;

/// Entries of an [`ActuatorPoint`].
const POINT: usize = 4;

/// The most numbers that a function depends on, and gives.
const INPUTS: usize = POINT + MAX_ACTUATOR_STATES + MAX_ACTUATOR_PARAMETERS;
const OUTPUTS: usize = 1 + MAX_ACTUATOR_STATES;

/// An actuator as a function of numbers: of the point, the state, then the parameters; to the signal and the next state.
struct OfNumbers<F> {
    own: F,
    states: usize,
}

impl<F: ActuatorFunction> NumberFunction for OfNumbers<F> {
    fn evaluate<T: Scalar>(&self, x: &[T], out: &mut [T]) {
        let (point, rest) = x.split_at(POINT);
        let (state, parameters) = rest.split_at(self.states);
        let at = ActuatorPoint {
            u: point[0],
            q: point[1],
            v: point[2],
            dt: point[3],
        };
        let (signal, next) = out.split_at_mut(1);
        signal[0] = self.own.respond(&at, state, parameters, next);
    }
}

/// An [`ActuatorFunction`] with its parameters.
#[derive(Clone)]
pub(super) struct Function<P> {
    function: Arc<dyn Erased<CHUNK>>,
    states: usize,
    parameters: Vec<P>,
}

impl<P: fmt::Debug> fmt::Debug for Function<P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Function")
            .field("states", &self.states)
            .field("parameters", &self.parameters)
            .finish_non_exhaustive()
    }
}

/// Equal if both share one function object and have the same parameters.
impl<P: PartialEq> PartialEq for Function<P> {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.function, &other.function) && self.parameters == other.parameters
    }
}

numbers! { struct Function {
    function: kept(), states: kept(), parameters: parameters("parameter of an actuator"),
} }

impl Function<f64> {
    pub(super) fn new(own: impl ActuatorFunction, parameters: &[f64]) -> Self {
        let (states, n) = (own.states(), parameters.len());
        assert!(
            n <= MAX_ACTUATOR_PARAMETERS && states <= MAX_ACTUATOR_STATES,
            "an actuator with {n} parameters and {states} state variables, at most {MAX_ACTUATOR_PARAMETERS} and {MAX_ACTUATOR_STATES} are possible"
        );
        Self {
            function: erase(OfNumbers { own, states }),
            states,
            parameters: parameters.to_vec(),
        }
    }
}

impl<P: Scalar> Function<P> {
    pub(super) fn states(&self) -> usize {
        self.states
    }

    /// As for [`Activation::respond`](super::Activation::respond).
    pub(super) fn respond<L: Over<P>>(
        &self,
        at: &Arguments<L>,
        dt: P,
        w: &[L],
        next: &mut [L],
    ) -> L {
        let mut x = [L::zero(); INPUTS];
        let (used, outputs) = (POINT + w.len() + self.parameters.len(), 1 + w.len());
        x[..POINT].copy_from_slice(&[at.u, at.q, at.v, dt.into()]);
        let (state, parameters) = x[POINT..].split_at_mut(w.len());
        state.copy_from_slice(w);
        for (x, &own) in parameters.iter_mut().zip(&self.parameters) {
            *x = own.into();
        }
        let mut y = [L::zero(); OUTPUTS];
        let out = &mut y[..outputs];
        evaluate::<L, CHUNK, INPUTS, OUTPUTS>(&*self.function, "an actuator", &x[..used], out);
        next.copy_from_slice(&out[1..]);
        out[0]
    }
}
