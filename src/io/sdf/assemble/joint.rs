//! Joints, and what stands between them and the links that they carry.
//!
//! An SDF joint has a frame J of its own; the model's joints have the child link at J when they are at zero. Where the child
//! stands elsewhere, a link without inertia in J, called like the joint, is put between, and the child is fixed to it:
//!
//! `X_PC(q) = X_PJ X(q) X_JC`; towards the root, from the child to the parent, `X_CP(q) = X_CJ X(q)⁻¹ X_JP`,
//! where `X(q)⁻¹` is the same motion about the opposite axis. A ball turns by the inverse rotation then.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{Matrix3, Vector3};

use super::Assembly;
use crate::error::LoadError;
use crate::io::motion::{Axis, without_leader};
use crate::io::sdf::scene::{Follow, FrameEntry, FrameKind, Motion, Scene};
use crate::io::sdf::tree::{Edge, Traversal, ends};
use crate::joint::JointKind;
use crate::model::{JointSpec, LinkSpec, Mimic, Mimicry, unit};
use crate::nested::IntoNested;
use crate::spatial::Transform;

/// Largest deviation of a child link's pose from its joint's frame at which it is taken to stand on it: the rounding of a chain of poses.
const SAME_FRAME: f64 = 1e-12;

impl Assembly<'_, '_> {
    /// Adds a joint and what stands between it and the link that it carries.
    pub(super) fn joint(&mut self, edge: Edge) -> Result<(), LoadError> {
        let joint = &self.scene.joints[edge.joint];
        let frame = &self.scene.frames[joint.frame];
        let at = &frame.place.position;
        self.builder.set_position(true, &frame.name, at.clone());
        let ends = ends(self.scene, self.placements, edge.joint)?;
        let X_WJ = self.placements.X_WF[joint.frame];
        // From here on A is the end at the root, B the other one.
        let (a, b) = match edge.direction {
            Traversal::Forward => (ends.parent, ends.child),
            Traversal::Backward => (ends.child, ends.parent),
        };
        let X_AJ = self.X_W(a).inverse() * X_WJ;
        let X_JB = X_WJ.inverse() * self.X_W(b);
        let (from, to) = (self.link_name(a), self.link_name(b));
        if joint.motions.is_empty() {
            let spec = JointSpec::new(&frame.name, JointKind::Fixed, from, to);
            self.builder.add_joint(spec.with_placement(X_AJ * X_JB));
            return Ok(());
        }
        let on_joint = is_identity(&X_JB).then_some(&to);
        let at = match self.universal(edge, &from)? {
            Some(spec) => self.single(edge, spec.with_placement(X_AJ), on_joint),
            None => self.motions(edge, from, X_AJ, on_joint)?,
        };
        if at != to {
            let name = format!("{}::fixed", frame.name);
            let spec = JointSpec::new(name, JointKind::Fixed, at, to);
            self.builder.add_joint(spec.with_placement(X_JB));
        }
        Ok(())
    }

    /// Notes the joints that others follow; a name that is none shows where it is needed.
    pub(super) fn find_leaders(&mut self) {
        let joints = self.scene.joints.iter();
        let follows = joints.nested(|joint| {
            let mimics = joint.motions.iter().filter_map(|own| own.mimic.as_ref());
            mimics.map(|follow| (joint.frame, follow))
        });
        let leaders = follows.filter_map(|(frame, follow)| self.leader(frame, follow).ok());
        self.leaders = leaders.collect();
    }

    /// A joint of two motions as one universal joint between a link and one without name yet; `None` for other joints, and where one of the
    /// motions follows or leads, or both are about one axis.
    fn universal(&mut self, edge: Edge, from: &str) -> Result<Option<JointSpec>, LoadError> {
        /// Least sine of the angle between the axes.
        const ACROSS: f64 = 1e-3;
        let joint = &self.scene.joints[edge.joint];
        let [first, second] = &joint.motions[..] else {
            return Ok(None);
        };
        let axes = [
            self.axis(joint.frame, first)?,
            self.axis(joint.frame, second)?,
        ];
        let [x, y] = axes;
        let is_tied =
            self.leaders.contains(&edge.joint) || first.mimic.is_some() || second.mimic.is_some();
        // The builder finds values that are NaN.
        let sine = unit(&x).cross(&unit(&y)).norm();
        if is_tied || sine < ACROSS {
            return Ok(None);
        }
        let backward = edge.direction == Traversal::Backward;
        let (a, b, sign) = if backward { (1, 0, -1.0) } else { (0, 1, 1.0) };
        if backward {
            let reason = "the tree leads from the child to the parent: the first coordinate is about axis2, both turn the other way";
            let place = &self.scene.frames[joint.frame].place;
            self.context.warn(place, reason);
        }
        let along = |k: usize| Axis {
            axis: axes[k] * sign,
            ..joint.motions[k].axis.clone()
        };
        let name = &self.scene.frames[joint.frame].name;
        let spec = JointSpec::new(name, JointKind::Universal, from, "")
            .along(along(a))
            .with_second_axis(along(b));
        Ok(Some(spec))
    }

    /// Adds a single moving joint, to a link `to` if that stands on it; returns the link at its end.
    fn single(&mut self, edge: Edge, spec: JointSpec, to: Option<&String>) -> String {
        let joint = &self.scene.joints[edge.joint];
        let name = &self.scene.frames[joint.frame].name;
        let at = to.cloned().unwrap_or_else(|| self.between(name));
        self.builder.add_joint(spec.with_child(&at));
        at
    }

    /// Adds the moving joints from a link on, the first placed in it, the last one to a link `to` if that stands there;
    /// returns the link at their end.
    fn motions(
        &mut self,
        edge: Edge,
        from: String,
        X_AJ: Transform<f64>,
        to: Option<&String>,
    ) -> Result<String, LoadError> {
        let mut order: Vec<usize> = (0..self.scene.joints[edge.joint].motions.len()).collect();
        if edge.direction == Traversal::Backward {
            order.reverse();
        }
        let (mut at, mut placement) = (from, X_AJ);
        for (k, &i) in order.iter().enumerate() {
            let is_last = k + 1 == order.len();
            let next = match to {
                Some(to) if is_last => to.clone(),
                _ => self.between(&motion_name(self.scene, edge.joint, i)),
            };
            let spec = self.motion(edge, i, &at, &next)?;
            let position = self.scene.frames[self.scene.joints[edge.joint].frame]
                .place
                .position
                .clone();
            self.builder.set_position(true, &spec.name, position);
            self.builder.add_joint(spec.with_placement(placement));
            (at, placement) = (next, Transform::identity());
        }
        Ok(at)
    }

    /// Adds a link without inertia, called like the joint if that is free.
    fn between(&mut self, joint: &str) -> String {
        let mut name = joint.to_owned();
        while !self.names.insert(name.clone()) {
            name += "::joint";
        }
        self.builder.add_link(LinkSpec::new(&name));
        name
    }

    fn motion(
        &mut self,
        edge: Edge,
        i: usize,
        from: &str,
        to: &str,
    ) -> Result<JointSpec, LoadError> {
        let joint = &self.scene.joints[edge.joint];
        let motion = &joint.motions[i];
        let mut axis = self.axis(joint.frame, motion)?;
        if edge.direction == Traversal::Backward {
            axis = -axis;
            if motion.kind == JointKind::Spherical {
                let reason = "the tree leads from the child to the parent: the coordinates are those of the inverse rotation";
                let place = &self.scene.frames[joint.frame].place;
                self.context.warn(place, reason);
            }
        }
        let name = motion_name(self.scene, edge.joint, i);
        let spec = JointSpec::new(name, motion.kind, from, to).along(Axis {
            axis,
            ..motion.axis.clone()
        });
        let mimic = motion.mimic.as_ref();
        let mimic = mimic.map(|follow| self.mimic(joint.frame, follow));
        Ok(match mimic.transpose()?.flatten() {
            Some(mimic) => spec.with_mimic(mimic),
            None => spec,
        })
    }

    /// The axis in the frame of the joint.
    fn axis(&self, frame: usize, motion: &Motion) -> Result<Vector3<f64>, LoadError> {
        let axis = motion.axis.axis;
        let Some(name) = &motion.expressed_in else {
            return Ok(axis);
        };
        let entry = &self.scene.frames[frame];
        let expressed_in = self.scene.resolve(entry.scope, name, &entry.place)?;
        let R_W = |frame: usize| self.placements.X_WF[frame].rotation;
        let R_JF = R_W(frame).transpose() * R_W(expressed_in);
        Ok(R_JF * axis)
    }

    /// q = m (`q_leader` − reference) + offset  is  m · `q_leader` + (offset − m · reference).
    ///
    /// None where there is no leader, if the joint moves by itself anyway.
    fn mimic(&mut self, frame: usize, follow: &Follow) -> Result<Option<Mimic>, LoadError> {
        let entry = &self.scene.frames[frame];
        let leader = match self.leader(frame, follow) {
            Err(_) if self.builder.mimicry == Mimicry::Independent => {
                let reason = without_leader(&follow.mimic.leader);
                self.context.warn(&entry.place, reason);
                return Ok(None);
            }
            leader => leader?,
        };
        let Mimic {
            multiplier, offset, ..
        } = follow.mimic;
        Ok(Some(Mimic {
            leader: motion_name(self.scene, leader, follow.axis),
            multiplier,
            offset: offset - multiplier * follow.reference,
        }))
    }

    /// The joint that is followed.
    fn leader(&self, frame: usize, follow: &Follow) -> Result<usize, LoadError> {
        let FrameEntry { scope, place, .. } = &self.scene.frames[frame];
        let leader = &follow.mimic.leader;
        match self.scene.frames[self.scene.resolve(*scope, leader, place)?].kind {
            FrameKind::Joint(joint) => Ok(joint),
            _ => Err(place.unknown(leader)),
        }
    }
}

/// The name of one motion of a joint: that of the joint, if it is the only one.
pub(in crate::io::sdf) fn motion_name(scene: &Scene, joint: usize, motion: usize) -> String {
    let entry = &scene.joints[joint];
    let name = &scene.frames[entry.frame].name;
    match (entry.motions.len(), motion) {
        (0 | 1, 0) => name.clone(),
        (_, 0) => format!("{name}::axis"),
        _ => format!("{name}::axis2"),
    }
}

fn is_identity(X: &Transform<f64>) -> bool {
    let turn = (X.rotation - Matrix3::identity()).amax();
    turn.max(X.translation.amax()) <= SAME_FRAME
}
