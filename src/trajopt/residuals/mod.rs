//! Residuals of states, inputs and robots.

mod distance;
mod frame;
mod limits;
mod schedule;
mod state;
mod whole_body;

pub use distance::LinkDistances;
pub use frame::{
    FrameDistance, FrameOrientation, FramePose, FramePosition, FrameVelocity, Obstacle,
};
pub use limits::{effort_barrier, position_barrier, position_bounds, velocity_barrier};
pub use schedule::Schedule;
pub use state::{InputError, StateError};
pub use whole_body::{CenterOfMass, CentroidalMomentum};

use crate::scalar::Scalar;

/// r = x − target, entry by entry.
fn away_from<T: Scalar>(target: &[f64], x: &[T], r: &mut [T]) {
    for (r, (&x, &target)) in r.iter_mut().zip(x.iter().zip(target)) {
        *r = x - target;
    }
}
