//! Residuals of states, inputs and robots.

mod frame;
mod limits;
mod state;
mod whole_body;

pub use frame::{
    FrameDistance, FrameOrientation, FramePose, FramePosition, FrameVelocity, Obstacle,
};
pub use limits::{effort_barrier, position_barrier, position_bounds, velocity_barrier};
pub use state::{InputError, StateError};
pub use whole_body::{CenterOfMass, CentroidalMomentum};
