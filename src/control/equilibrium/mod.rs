//! A pose in which a robot stays, with the input and the deflections of contact that hold it there.
//!
//! | file | what it is |
//! |---|---|
//! | `stance` | where the search begins: on the ground, by statics |
//! | `rest` | accelerations that shall be zero, as residuals |
//! | `regulator` | the regulator about an equilibrium |

mod regulator;
mod rest;
mod stance;

use std::fmt;

use nalgebra::DVector;

use crate::least_squares::{self, Options, Status};
use crate::sim::{Simulator, State};
use rest::Rest;

pub use regulator::{Dropped, EquilibriumLqr};

/// A fixed point of a simulator's step: x⁺ = x with v = 0 and a constant input.
///
/// # Examples
/// ```
/// use dualbody::{Simulator, State, control::Equilibrium, model::samples};
///
/// // A pendulum with a motor can be held at 0.3 rad, with the torque ½ m g l sin q.
/// let simulator = Simulator::new(samples::pendulum());
/// let held = Equilibrium::find(&simulator, &State::new(&[0.3], &[0.0]), &[0.0]);
/// assert!(held.is_found());
/// assert!((held.input[0] - 0.5 * 9.81 * held.state.q[0].sin()).abs() < 1e-6);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Equilibrium {
    /// Pose, at rest, with the state of contact.
    pub state: State,
    /// Input that holds it.
    pub input: DVector<f64>,
    /// Largest acceleration that is left, rad/s² or m/s²; next to zero if it is found.
    pub acceleration: f64,
    /// Termination status.
    pub status: EquilibriumStatus,
    /// Iterations of the search.
    pub iterations: usize,
}

/// Termination status of the search for an equilibrium.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum EquilibriumStatus {
    /// Nothing moves.
    Found,
    /// Near the guess nothing that holds the robot was found: inputs are too weak or too few, nothing carries it, or the guess is too far away.
    NotHeld,
    /// A number is not finite.
    Diverged,
    /// A [`StopSignal`](crate::StopSignal) was set.
    Stopped,
}

/// Force that counts as none, beside the weight.
const NEGLIGIBLE: f64 = 1e-8;
/// Rounds, each of which begins where the one before ended.
const ROUNDS: usize = 4;
/// Iterations of a round.
const MOST_ITERATIONS: usize = 40;

impl Equilibrium {
    /// Finds an equilibrium near a guess: pose, input and bristles of soft contact, all at once.
    ///
    /// A floating robot with contacts is first moved along gravity to where it touches the ground, with what statics says of inputs and forces there:
    /// points within a centimetre of the ground carry it, by the least torques. Then accelerations, weighted by the roots of the inertias, are made zero
    /// by Levenberg and Marquardt's method on the Jacobians of the step. As a rule many poses and inputs are equilibria; one near the guess is found.
    /// Allocates.
    ///
    /// * `guess` – pose of the start, with the state of contact if it has one; its velocity is not used
    /// * `u` – input of the start; that of statics takes its place where a robot is put on the ground
    ///
    /// # Panics
    /// If state or input have the wrong length, or inputs have [activations](crate::sim::Activation): find the equilibrium of the simulator before it gets them.
    ///
    /// # References
    /// [Levenberg 1944; Marquardt 1963; Moré 1978].
    pub fn find(simulator: &Simulator, guess: &State, u: &[f64]) -> Self {
        assert!(
            simulator.activations().is_empty(),
            "inputs of \"{}\" have activations: find the equilibrium of the simulator before it gets them",
            simulator.model().name()
        );
        let mut start = simulator.state(guess.q.as_slice(), &vec![0.0; simulator.model().nv()]);
        if start.contact.len() == guess.contact.len() {
            start.contact.copy_from(&guess.contact);
        }
        let mut input = DVector::from_column_slice(u);
        stance::begin(simulator, &mut start, &mut input);
        let mut rest = Rest::new(simulator, start, input);
        let (mut status, mut iterations) = (EquilibriumStatus::NotHeld, 0);
        for _ in 0..ROUNDS {
            let (found, taken) = round(&mut rest);
            (status, iterations) = (found, iterations + taken);
            if status != EquilibriumStatus::NotHeld {
                break;
            }
        }
        Self {
            acceleration: rest.acceleration(),
            status,
            iterations,
            state: rest.state,
            input: rest.input,
        }
    }

    /// Whether the status is [`EquilibriumStatus::Found`].
    pub fn is_found(&self) -> bool {
        self.status == EquilibriumStatus::Found
    }
}

/// Searches from where the last round ended. Status and iterations.
fn round(rest: &mut Rest<'_>) -> (EquilibriumStatus, usize) {
    let options = Options {
        max_iterations: MOST_ITERATIONS,
        ..Options::default()
    };
    let from = rest.from.clone();
    let found = least_squares::solve(rest, &from, &options);
    rest.move_to(&found.x);
    rest.from = found.x;
    let accelerations = &found.residuals[..rest.scale.len()];
    let largest = accelerations.iter().fold(0.0_f64, |m, r| m.max(r.abs()));
    let status = match found.status {
        Status::Diverged => EquilibriumStatus::Diverged,
        Status::Stopped => EquilibriumStatus::Stopped,
        _ if largest < NEGLIGIBLE * rest.weight => EquilibriumStatus::Found,
        _ => EquilibriumStatus::NotHeld,
    };
    (status, found.iterations)
}

impl fmt::Display for EquilibriumStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Found => "found",
            Self::NotHeld => "not held: nothing near the guess carries the robot, the inputs are too weak or too few, or the guess is too far away",
            Self::Diverged => "a number is not finite",
            Self::Stopped => "stopped by a signal",
        })
    }
}
