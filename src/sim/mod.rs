//! Simulation: state, actuation, external forces, integrators, one step, a rollout, and batches of them.
//!
//! One step holds the input constant and is a function of state and input over any scalar, so that its exact Jacobians come from
//! running the very same step on dual numbers.

mod actuation;
mod assembly;
mod batch;
mod constrained;
mod contact;
mod encounter;
mod force;
mod horizon;
mod implicit_joints;
mod integrator;
mod interop;
mod middle;
mod reason;
mod rollout;
mod rows;
mod simulator;
mod state;
mod working_set;

pub use actuation::{
    Actuation, Actuator, CoulombFriction, PositionLimits, TorqueSpeed, VelocityLimit,
};
pub use assembly::{Assembly, AssemblyError};
pub(crate) use batch::for_each_part;
pub use batch::{BATCH_WIDTH, BatchMoment, BatchRollout, BatchScalar, BatchSimulator, BatchStates};
pub(crate) use constrained::ConstrainedScratch;
pub use contact::ContactReport;
pub(crate) use contact::ContactScratch;
pub(crate) use encounter::{Encounter, ROWS};
pub(crate) use force::FrameTerm;
pub use force::{AppliedForce, ExternalForce, ForceFunction, FrameActuator, MAX_FORCE_PARAMETERS};
pub(crate) use implicit_joints::Stop;
pub(crate) use integrator::{AtEnd, Solution};
pub use integrator::{Integrator, StepScratch};
pub use interop::{Engine, EngineCoordinates};
pub(crate) use middle::Middle;
pub use reason::ContactReason;
pub use rollout::{Rollout, RolloutStatus, SolverFailure};
pub(crate) use rollout::{column_names, numbered, write_row};
pub use simulator::Simulator;
pub use state::State;
