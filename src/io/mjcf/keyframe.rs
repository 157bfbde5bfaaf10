//! Keyframes as named states.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::collections::HashMap;

use nalgebra::{DVector, Vector3};

use super::body::Bodies;
use super::entry::Entry;
use super::joint::{JointEntry, Kind};
use super::scene::MjcfKeyframe;
use super::walk::Part;
use crate::error::LoadError;
use crate::io::context::Context;
use crate::model::{JointId, Model};
use crate::nested::IntoNested;
use crate::sim::State;
use crate::spatial::Quaternion;

/// Maximum length of a keyframe: the number of coordinates of the largest possible robot.
const MOST: usize = 10_000_000;

/// The model that keyframes are of.
pub(super) struct Target<'a> {
    pub(super) model: &'a Model,
    pub(super) bodies: &'a Bodies,
    pub(super) floats: bool,
    /// Joints of the model by name.
    pub(super) ids: HashMap<&'a str, JointId>,
    /// Configuration in which the file has its bodies.
    pub(super) reference: &'a DVector<f64>,
    pub(super) actuators: usize,
    /// Actuators that have an activation.
    pub(super) activations: usize,
}

/// Reads a keyframe; `None`, with a remark, If it belongs to another robot.
pub(super) fn read(
    part: &Part<'_, '_>,
    of: &Target<'_>,
    context: &mut Context<'_>,
) -> Result<Option<MjcfKeyframe>, LoadError> {
    let entry = part.plain();
    let joints = || of.bodies.entries.iter().nested(|body| &body.joints);
    let nq: usize = joints().map(|joint| joint.kind.nq()).sum();
    let nv: usize = joints().map(|joint| joint.kind.nv()).sum();
    let qpos = numbers(&entry, "qpos", nq)?;
    let qvel = numbers(&entry, "qvel", nv)?;
    let control = numbers(&entry, "ctrl", of.actuators)?;
    let activation = numbers(&entry, "act", of.activations)?.unwrap_or_default();
    let time = entry.number("time")?.unwrap_or_default();
    if of.model.joints().len() + usize::from(of.model.has_floating_base()) < joints().count() {
        context.ignore(&part.node.place(), "joints of the keyframe are locked");
        return Ok(None);
    }
    let mut state = State::new(of.reference.as_slice(), &vec![0.0; of.model.nv()]);
    let (mut at_q, mut at_v) = (0, 0);
    for joint in joints() {
        let Some((q, v)) = of.ranges(joint) else {
            return Ok(None);
        };
        if let Some(qpos) = &qpos {
            let own = &mut state.q.as_mut_slice()[q.clone()];
            own.copy_from_slice(&qpos[at_q..at_q + joint.kind.nq()]);
            if !normalize(own, joint.kind) {
                return Err(entry.malformed("qpos", "a quaternion is zero"));
            }
        }
        if let Some(qvel) = &qvel {
            let own = &mut state.v.as_mut_slice()[v];
            own.copy_from_slice(&qvel[at_v..at_v + joint.kind.nv()]);
            if joint.kind == Kind::Free {
                into_body(own, &state.q.as_slice()[q]);
            }
        }
        at_q += joint.kind.nq();
        at_v += joint.kind.nv();
    }
    Ok(Some(MjcfKeyframe {
        name: part.name().unwrap_or_default(),
        time,
        // Of all actuators: the scene keeps those that it models.
        state: state.with_activation(DVector::from_vec(activation)),
        control: DVector::from_vec(control.unwrap_or_default()),
    }))
}

impl Target<'_> {
    /// Places of the coordinates of a joint.
    fn ranges(
        &self,
        joint: &JointEntry,
    ) -> Option<(std::ops::Range<usize>, std::ops::Range<usize>)> {
        if self.floats && joint.kind == Kind::Free {
            return Some((0..7, 0..6));
        }
        let id = *self.ids.get(joint.name.as_str())?;
        Some((self.model.joint_q(id), self.model.joint_v(id)))
    }
}

/// Exactly so many numbers, or none.
fn numbers(
    entry: &Entry<'_, '_>,
    name: &'static str,
    count: usize,
) -> Result<Option<Vec<f64>>, LoadError> {
    let numbers = entry.list(name, MOST)?;
    match &numbers {
        Some(numbers) if numbers.len() != count => {
            let reason = format!("has {} numbers, expected {count}", numbers.len());
            Err(entry.malformed(name, &reason))
        }
        _ => Ok(numbers),
    }
}

/// Makes the quaternion of a joint one of unit norm; `false` if it is zero.
fn normalize(q: &mut [f64], kind: Kind) -> bool {
    let at = match kind {
        Kind::Ball => 0,
        Kind::Free => 3,
        _ => return true,
    };
    let largest = q[at..].iter().fold(0.0_f64, |max, x| max.max(x.abs()));
    if largest == 0.0 {
        return false;
    }
    q[at..].iter_mut().for_each(|x| *x /= largest);
    let quaternion = Quaternion::from_slice(&q[at..]).normalized();
    quaternion.write_to(&mut q[at..]);
    true
}

/// The linear velocity along the axes of the world becomes one along those of the body.
fn into_body(v: &mut [f64], q: &[f64]) {
    let R_WB = Quaternion::from_slice(&q[3..]).to_matrix();
    let v_B = R_WB.transpose() * Vector3::from_column_slice(&v[..3]);
    v[..3].copy_from_slice(v_B.as_slice());
}
