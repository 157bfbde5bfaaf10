//! The configuration in which a file has its bodies.

use std::collections::HashMap;

use nalgebra::DVector;

use super::body::Bodies;
use super::joint::{JointEntry, Kind};
use crate::model::{JointId, Model};
use crate::spatial::Quaternion;

/// Configuration of a model in which the file has its bodies.
pub(super) fn reference(model: &Model, bodies: &Bodies, floats: bool) -> DVector<f64> {
    let mut q = model.neutral();
    let by_name: HashMap<&str, _> = (model.joints().iter().zip(0..))
        .map(|(joint, i)| (joint.name.as_str(), i))
        .collect();
    let range_of = |joint: &JointEntry| {
        let base =
            (floats && joint.kind == Kind::Free && model.has_floating_base()).then_some(0..7);
        base.or_else(|| Some(model.joint_q(JointId(*by_name.get(&*joint.name)?))))
    };
    for body in bodies.entries.iter().skip(1) {
        for joint in &body.joints {
            let Some(range) = range_of(joint) else {
                continue;
            };
            let own = &mut q.as_mut_slice()[range];
            match joint.kind {
                Kind::Hinge | Kind::Slide if own.len() == 1 => own[0] = joint.reference,
                Kind::Free if own.len() == 7 => {
                    own[..3].copy_from_slice(body.X_PB.translation.as_slice());
                    Quaternion::from_matrix(&body.X_PB.rotation).write_to(&mut own[3..]);
                }
                _ => {}
            }
        }
    }
    q
}
