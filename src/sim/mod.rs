//! Simulation: state, actuation, integrators, one step, a rollout.
//!
//! One step holds the input constant and is a function of state and input over any scalar, so that its exact Jacobians come from
//! running the very same step on dual numbers.

mod integrator;
mod interop;
mod rollout;
mod simulator;
mod state;

pub use integrator::{Integrator, StepScratch};
pub use interop::Engine;
pub use rollout::{Rollout, RolloutStatus};
pub use simulator::Simulator;
pub use state::State;
