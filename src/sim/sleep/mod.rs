//! Sleep of resting islands: trees of joints that touch or are tied to each other, and have hardly moved for a while, stay where they are at no cost.
//!
//! | file | what |
//! |---|---|
//! | `record` | what a [state](super::State) says of it, in numbers |
//! | `trees` | trees of joints, those that never sleep, and those that constraints tie to each other |
//! | `sleeper` | a step: who sleeps in it, and who falls asleep after it |
//! | `wake` | sleeping bodies that others reach within a step |

mod record;
mod sleeper;
mod trees;
mod wake;

use super::simulator::Simulator;
use super::state::State;
use crate::dynamics::trees;
use crate::model::Model;
use crate::numbers::Domain;
use crate::scalar::Scalar;
pub(super) use sleeper::Sleeper;
use trees::Trees;

/// When resting islands fall asleep, an option of a simulator: [`Simulator::with_sleeping`].
///
/// A *tree* is a free object, or a robot: all bodies that joints connect. An *island* consists of trees that touch each other, or that constraints
/// connect. It falls asleep when all of its coordinates have been slower than a speed for a time, at the end of every step. From then on, steps leave
/// its configuration as it is, with a velocity of exactly zero. They find no contacts and forces of it, and cost almost nothing for it.
///
/// An island wakes as a whole, with the full step in which one of these happens:
/// - something awake reaches one of its bodies, by the velocities at the start of the step and gravity;
/// - its configuration or velocity, or a bristle of its contacts, is not the one with which it fell asleep, because the caller changed the state.
///
/// A tree with an input never sleeps: a joint [input](Simulator::actuated), a frame actuator or a tendon servo. Nor does one with an
/// [external force](super::ExternalForce). An object that is moved by hand, through its state, is awake. Terrain and shapes fixed to the world neither wake what rests on them nor keep it awake.
///
/// A step is a function of state and input still: what sleeps is a part of the [state](State::sleep). [`Simulator::state`] makes a state in which all
/// is awake. So is the result of [`Simulator::carried_state`], since supports may be gone. After a change of the simulator itself, such as gravity or
/// friction, make a new state from q and v.
///
/// # Limitations
/// Motion that is slower than `speed` for longer than `time` stops: creep on a slope, or the first moments of a fall from an unstable equilibrium. In
/// that time an island moves by at most `speed` · `time`, so a rest position differs by little more than that from one without sleep.
///
/// Derivatives ignore sleep: [`linearize`](Simulator::linearize), vector–Jacobian products, gradients of rollouts, trajectory optimisation and
/// identification take all steps awake, from the same state. So do steps over other scalars than `f64`, [`SingleBatch`](super::SingleBatch), and questions
/// such as [`Simulator::contact_report`]. A step with sleep cannot be recorded as a graph: use `with_sleeping(None)` for that.
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

/// Numbers of a state that say what sleeps.
pub(super) fn n_sleep<P: Scalar>(model: &Model<P>) -> usize {
    record::NUMBERS * trees(model).chunk_by(|a, b| a == b).count()
}

impl Simulator {
    /// The names of the links that sleep in a state, in the order of [`Model::link_names`]; empty without [`Sleeping`]. Bodies that the next step wakes
    /// because something reaches them are among them. Allocates.
    ///
    /// # Panics
    /// If the state has the wrong length.
    pub fn asleep(&self, state: &State) -> Vec<&str> {
        self.check(state);
        if self.sleeping().is_none() {
            return Vec::new();
        }
        let trees = Trees::new(self);
        let mut asleep = Vec::new();
        trees.asleep_into(state, &mut asleep);
        let links = self.model().link_names().into_iter().filter(|name| {
            let frame = self.model().frame(name);
            let body = frame.and_then(|frame| self.model().frame_of(frame).body);
            body.and_then(|body| trees.of_body(body))
                .is_some_and(|tree| asleep[tree])
        });
        links.collect()
    }
}
