//! Environments of reinforcement learning over lanes: tasks whose episodes start, are observed, rewarded and started again, many at once.
//!
//! A task is an [`Environment`]; [`Environments`] runs it.

mod environment;
mod episodes;
mod memory;
mod rules;
mod runner;
mod transitions;

pub use environment::{Environment, Episode};
pub use rules::AutoReset;
pub use runner::Environments;
pub use transitions::Transitions;
