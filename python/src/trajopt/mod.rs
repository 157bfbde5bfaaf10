//! Trajectory optimisation of simulators: problems, differential dynamic programming, receding horizon.

mod ddp;
mod problem;
mod receding_horizon;
mod residual;

pub(crate) use ddp::_ddp;
pub(crate) use problem::{_position_bounds, _trajectory_cost};
pub(crate) use receding_horizon::PyRecedingHorizon;
