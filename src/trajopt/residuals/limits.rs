//! Joint limits as bounds and barriers.

use super::{InputError, StateError};
use crate::model::Limits;
use crate::model::manifold::v_range;
use crate::sim::{Simulator, own_joints};
use crate::trajopt::activation::Activation;
use crate::trajopt::robot::Robot;

/// Bounds on the difference of the state to the neutral one, length `ndx`, from the position limits of all joints of one degree of
/// freedom: for [`Constraint::within`](crate::trajopt::Constraint::within) a [`StateError::to_neutral`].
pub fn position_bounds<R: Robot>(robot: &R) -> (Vec<f64>, Vec<f64>) {
    state_bounds(robot, 0, |limits| (limits.lower, limits.upper))
}

/// Soft position limits of the joints: a residual and its barrier, for [`Cost::with`](crate::trajopt::Cost::with).
pub fn position_barrier<R: Robot>(robot: &R) -> (Activation, StateError) {
    let (lower, upper) = position_bounds(robot);
    let barrier = Activation::Barrier { lower, upper };
    (barrier, StateError::to_neutral(robot))
}

/// Soft velocity limits of the joints: a residual and its barrier.
pub fn velocity_barrier<R: Robot>(robot: &R) -> (Activation, StateError) {
    let speed = |limits: &Limits| (limits.velocity.map(|limit| -limit), limits.velocity);
    let (lower, upper) = state_bounds(robot, robot.model().nv(), speed);
    let barrier = Activation::Barrier { lower, upper };
    (barrier, StateError::to_neutral(robot))
}

/// Soft effort limits of the joints, on their inputs: a residual and its barrier.
pub fn effort_barrier(simulator: &Simulator) -> (Activation, InputError) {
    let (lower, upper) = simulator.effort_bounds();
    let barrier = Activation::Barrier { lower, upper };
    (barrier, InputError::to_zero(simulator))
}

/// Bounds on a tangent of the state, from `first` on those that `limits` gives for a joint; infinite elsewhere.
fn state_bounds<R: Robot>(
    robot: &R,
    first: usize,
    limits: impl Fn(&Limits) -> (Option<f64>, Option<f64>),
) -> (Vec<f64>, Vec<f64>) {
    let (model, n) = (robot.model(), robot.ndx());
    let mut lower = vec![f64::NEG_INFINITY; n];
    let mut upper = vec![f64::INFINITY; n];
    for joint in own_joints(model) {
        let range = v_range(model.body(joint.body));
        let (low, high) = limits(joint.limits);
        if range.len() == 1 {
            lower[first + range.start] = low.unwrap_or(f64::NEG_INFINITY);
            upper[first + range.start] = high.unwrap_or(f64::INFINITY);
        }
    }
    (lower, upper)
}
