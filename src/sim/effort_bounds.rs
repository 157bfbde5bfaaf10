//! Bounds of inputs by the limits of motors and servos.

use super::Simulator;
use super::actuation::Interval;
use crate::model::manifold::v_range;
use crate::model::{JointPart, Model};
use crate::nested::IntoNested;

/// Bounds of an input without limits.
const NONE: Interval = Interval {
    lower: f64::NEG_INFINITY,
    upper: f64::INFINITY,
};

impl Simulator {
    /// Returns the lower and upper bounds of the input, length `nu`, infinite where there is no limit: effort limits of the actuated joints (for
    /// servos the ranges of their inputs), then limits of frame actuators and of tendon servos. For `Problem::with_input_bounds` of trajectory
    /// optimisation.
    pub fn effort_bounds(&self) -> (Vec<f64>, Vec<f64>) {
        let mut bounds = vec![NONE; self.model().nv()];
        for joint in own_joints(self.model()) {
            let range = v_range(self.model().body(joint.body));
            if let Some(effort) = joint.limits.effort {
                bounds[range].fill(Interval::symmetric(effort));
            }
        }
        let actuators = self.actuation().into_iter().nested(|own| own.actuators());
        for (own, actuator) in bounds.iter_mut().zip(actuators) {
            if let Some(servo) = &actuator.servo {
                *own = servo.input_range.unwrap_or(NONE);
            }
        }
        let joints = self.actuated().iter().map(|&k| bounds[k]);
        let frames = self.frame_actuators().iter().map(|own| {
            let servo = own.servo().and_then(|servo| servo.input_range);
            let range = servo.unwrap_or(NONE);
            Interval {
                lower: own.lower().unwrap_or(NONE.lower).max(range.lower),
                upper: own.upper().unwrap_or(NONE.upper).min(range.upper),
            }
        });
        let tendons = self.tendon_servos().iter();
        let tendons = tendons.map(|own| own.servo().input_range.unwrap_or(NONE));
        let all = joints.chain(frames).chain(tendons);
        all.map(|own| (own.lower, own.upper)).unzip()
    }
}

/// The joints with coordinates of their own, body by body.
pub(crate) fn own_joints(model: &Model) -> impl Iterator<Item = JointPart<'_>> {
    let joints = model.joint_parts();
    joints.filter(|joint| model.body(joint.body).coupling.is_none())
}
