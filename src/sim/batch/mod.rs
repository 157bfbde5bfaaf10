//! Many states of one robot, or of many variants of it, simulated at once.
//!
//! The states stand side by side in the lanes of a [`BatchScalar`], one group of [`BATCH_WIDTH`] after the other, and the very
//! [`Simulator::step_into`] that steps one state steps each group: nothing of the physics is written here. Groups share nothing,
//! so they are spread over the cores.
//!
//! A lane goes through the same operations in the same order as a single number does. So every state comes out with the very bits that a
//! [`Simulator`] of its own gives, wherever it stands in the batch, however many states and threads there are, and whatever
//! happens to the others. The last group is filled up with copies of the last state.
//!
//! Where the CPU has no registers for lanes, each state of a group goes through the code of one state.

mod control;
mod environments;
mod group;
mod groups;
mod one_by_one;
mod readout;
mod rollout;
mod simulator;
mod single;
mod states;
mod step_and_read;
mod worker;

pub use control::BatchMoment;
pub use environments::{AutoReset, Environment, Environments, Episode, Transitions};
pub use rollout::BatchRollout;
pub use simulator::BatchSimulator;
pub use single::{SINGLE_WIDTH, SingleBatch, SingleScalar};
pub use states::BatchStates;

use crate::scalar::Lanes;

pub use crate::scalar::BATCH_WIDTH;

/// The scalar of a batch.
pub type BatchScalar = Lanes<BATCH_WIDTH>;
