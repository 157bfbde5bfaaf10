//! Many states of one robot, or of many variants of it, simulated at once.
//!
//! The states occupy the lanes of a [`BatchScalar`], in groups of [`BATCH_WIDTH`]. [`Simulator::step_into`], which steps a single state, also steps
//! each group: this module contains no physics. Groups share no data and run on all cores.
//!
//! A lane performs the same operations in the same order as a single number. So each state is bit-identical to the result of a single [`Simulator`],
//! independent of its position in the batch, of the number of states and threads, and of the other states. Copies of the last state fill the last
//! group.
//!
//! On a CPU without vector registers for lanes, the code for a single state steps the states one by one.

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
