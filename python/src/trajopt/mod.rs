//! Trajectory optimisation of simulators: problems, differential dynamic programming, single shooting, direct transcription, receding horizon.

mod ddp;
mod problem;
mod receding_horizon;
mod residual;
mod shooting;
mod solution;
mod transcription;
mod user;

pub(crate) use ddp::_ddp;
pub(crate) use problem::{_position_bounds, _trajectory_cost};
pub(crate) use receding_horizon::PyRecedingHorizon;
pub(crate) use shooting::{_shooting_at, _shooting_variables, _single_shooting};
pub(crate) use transcription::{_curve_at, _transcription};
