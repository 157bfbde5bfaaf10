//! Equilibria: a pose with the input and the contact deflections that hold it.
//!
//! | file | content |
//! |---|---|
//! | `stance` | initial pose on the ground, by statics |
//! | `rest` | accelerations as residuals |
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
    /// Pose, at rest, with the contact state.
    pub state: State,
    /// Input that holds it.
    pub input: DVector<f64>,
    /// Largest remaining acceleration, rad/s² or m/s²; almost zero if the status is found.
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
    /// An equilibrium: all accelerations are zero.
    Found,
    /// No equilibrium was found near the guess: the inputs are too weak or too few, nothing supports the robot, or the guess is too far away.
    NotHeld,
    /// A value is not finite.
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
    /// Finds an equilibrium near a guess: pose, input and bristles of soft contact together.
    ///
    /// A floating robot with contacts is first moved along gravity to the ground. Statics gives the first inputs and forces: points within a
    /// centimetre of the ground support the robot with least torques. Then the Levenberg–Marquardt method, with the Jacobians of the step, drives the
    /// accelerations to zero, weighted by the square roots of the inertias. Usually many poses and inputs are equilibria; the result is one near the
    /// guess. Allocates.
    ///
    /// * `guess` – initial pose, with the contact state if it has one; its velocity is ignored
    /// * `u` – initial input; replaced by that of statics if the robot is moved to the ground
    ///
    /// # Panics
    /// If state or input have the wrong length.
    ///
    /// # References
    /// [Levenberg 1944; Marquardt 1963; Moré 1978].
    pub fn find(simulator: &Simulator, guess: &State, u: &[f64]) -> Self {
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
