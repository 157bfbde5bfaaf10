//! Limits of a robot's joints as bounds and barriers.

use super::{InputError, StateError};
use crate::model::manifold::v_range;
use crate::model::{JointPart, Limits, Model};
use crate::sim::Simulator;
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

impl Simulator {
    /// The effort limits of the actuated joints, then those of frame actuators, lower and upper, length `nu`, infinite where there are none, and where the
    /// input is the target of a servo: for [`Problem::with_input_bounds`](crate::trajopt::Problem::with_input_bounds).
    pub fn effort_bounds(&self) -> (Vec<f64>, Vec<f64>) {
        let mut largest = vec![f64::INFINITY; self.model().nv()];
        for joint in own_joints(self.model()) {
            let range = v_range(self.model().body(joint.body));
            if let Some(effort) = joint.limits.effort {
                largest[range].fill(effort);
            }
        }
        let actuators = self.actuation().into_iter().flat_map(|own| own.actuators());
        for (limit, _) in (largest.iter_mut().zip(actuators)).filter(|(_, own)| own.servo.is_some())
        {
            *limit = f64::INFINITY;
        }
        let efforts = self.actuated().iter().map(|&k| largest[k]);
        let frames = self.frame_actuators().iter();
        let lower = frames
            .clone()
            .map(|f| f.lower().unwrap_or(f64::NEG_INFINITY));
        let upper = frames.map(|f| f.upper().unwrap_or(f64::INFINITY));
        let below = efforts.clone().map(|limit| -limit).chain(lower);
        (below.collect(), efforts.chain(upper).collect())
    }
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

/// The joints with coordinates of their own, body by body.
fn own_joints(model: &Model) -> impl Iterator<Item = JointPart<'_>> {
    let joints = model.joint_parts();
    joints.filter(|joint| model.body(joint.body).coupling.is_none())
}
