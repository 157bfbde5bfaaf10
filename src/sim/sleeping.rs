//! When resting islands fall asleep: an option of a simulator.

use crate::dynamics::trees;
use crate::model::Model;
use crate::numbers::Domain;
use crate::scalar::Scalar;

/// When resting islands fall asleep, an option of a simulator: [`with_sleeping`](crate::Simulator::with_sleeping).
///
/// A *tree* is a free object, or a robot: all bodies that joints connect. An *island* consists of trees that touch each other, or that constraints
/// connect. It falls asleep when all of its coordinates have been slower than a speed for a time, at the end of every step. From then on, steps leave
/// its configuration as it is, with a velocity of exactly zero. They find no contacts and forces of it. Where all of a world sleeps, a step compares
/// and copies numbers; where a part is awake, a step also places all bodies and finds their inertia.
///
/// An island wakes as a whole, with the full step in which one of these happens:
/// - something awake reaches one of its bodies, by the velocities at the start of the step and gravity;
/// - its configuration or velocity, or a bristle of its contacts, is not the one with which it fell asleep, because the caller changed the state.
///
/// A tree with an input never sleeps: a joint [input](crate::Simulator::actuated), a frame actuator or a tendon servo. Nor does one with an [external
/// force](super::ExternalForce). An object that is moved by hand, through its state, is awake. Terrain and shapes fixed to the world neither wake
/// what rests on them nor keep it awake.
///
/// A step is a function of state and input still: what sleeps is a part of the [state](super::State::sleep).
/// [`Simulator::state`](crate::Simulator::state) makes a state in which all is awake. So is the result of
/// [`carried_state`](crate::Simulator::carried_state), since supports may be gone. After a change of the simulator itself, such as gravity or
/// friction, make a new state from q and v.
///
/// # Limitations
/// Motion that is slower than `speed` for longer than `time` stops: creep on a slope, or the first moments of a fall from an unstable equilibrium. In
/// that time an island moves by at most `speed` · `time`, so a rest position differs by little more than that from one without sleep.
///
/// Derivatives ignore sleep: [`linearize`](crate::Simulator::linearize), vector–Jacobian products, gradients of rollouts, trajectory optimisation and
/// identification take all steps awake, from the same state. So do steps over other scalars than `f64`, [`SingleBatch`](super::SingleBatch), and
/// questions such as [`contact_report`](crate::Simulator::contact_report). A step with sleep cannot be recorded as a graph: use `with_sleeping(None)`
/// for that.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sleeping {
    /// Largest rate of each coordinate at rest, m/s or rad/s. Larger values let islands sleep that creep or tremble. With zero only islands sleep that
    /// do not move at all.
    pub speed: f64,
    /// Time at rest after which an island falls asleep, s. With zero it does so after its first step at rest.
    pub time: f64,
}

impl Default for Sleeping {
    /// A millimetre per second, for half a second.
    fn default() -> Self {
        Self {
            speed: 1e-3,
            time: 0.5,
        }
    }
}

impl Sleeping {
    /// # Panics
    /// If a number is negative or not finite.
    pub(super) fn check(&self) {
        let Self { speed, time } = *self;
        let not_negative = Domain::NotNegative;
        not_negative.hold(
            format_args!("a speed of {speed} m/s below which islands sleep"),
            speed,
        );
        not_negative.hold(
            format_args!("a time of {time} s after which islands sleep"),
            time,
        );
    }
}

/// Numbers of a state that say of a tree whether it sleeps.
pub(super) const NUMBERS_OF_A_TREE: usize = 2;

/// Numbers of a state that say what sleeps.
pub(super) fn n_sleep<P: Scalar>(model: &Model<P>) -> usize {
    NUMBERS_OF_A_TREE * trees(model).chunk_by(|a, b| a == b).count()
}
