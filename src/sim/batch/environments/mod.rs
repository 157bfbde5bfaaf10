//! Environments of reinforcement learning over lanes: tasks whose episodes start, are observed, rewarded and started again, many at once.
//!
//! A task is an [`Environment`]; [`Environments`] runs it.

mod environment;
mod episodes;
mod runner;
mod transitions;

pub use environment::{Environment, Episode};
pub use runner::{AutoReset, Environments};
pub use transitions::Transitions;
