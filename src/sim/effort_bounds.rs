//! Bounds of inputs by the effort limits of a robot.

use super::Simulator;
use crate::model::manifold::v_range;
use crate::model::{JointPart, Model};

impl Simulator {
    /// The effort limits of the actuated joints, then those of frame actuators, lower and upper, length `nu`, infinite where there are none, and where the
    /// input is the target of a servo: for `Problem::with_input_bounds` of trajectory optimisation.
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

/// The joints with coordinates of their own, body by body.
pub(crate) fn own_joints(model: &Model) -> impl Iterator<Item = JointPart<'_>> {
    let joints = model.joint_parts();
    joints.filter(|joint| model.body(joint.body).coupling.is_none())
}
