//! Attaching robots, and adding frames and bodies.

use std::collections::HashSet;

use crate::error::{EditError, UnknownName};
use crate::joint::JointKind;
use crate::model::{Base, JointSpec, LinkSpec, Mimicry, Model, ModelBuilder};
use crate::spatial::Transform;

/// Name, after the prefix, of the joint that holds an attached robot.
pub(in crate::model) const ATTACHMENT: &str = "attachment";

impl ModelBuilder {
    /// Attaches another robot: its root link is welded to a frame of this one, by a fixed joint called
    /// `{prefix}attachment`.
    ///
    /// All names of the other robot get the prefix. Its gravity and the motion of its base are ignored. Name clashes are errors and leave this robot unchanged.
    ///
    /// * `frame` – a link or an added frame of this robot
    /// * `pose` – pose of the other robot's root link in that frame
    ///
    /// # Errors
    /// If there is no such frame, a name clashes, or the other robot does not have exactly one root.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{model::samples, spatial::Transform};
    ///
    /// let mut arm = samples::arm().to_builder();
    /// arm.attach(&samples::pendulum().to_builder(), "tool", "bob/", &Transform::identity())?;
    /// assert_eq!(arm.build()?.joint_names()[7], "bob/pivot");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn attach(
        &mut self,
        other: &Self,
        frame: &str,
        prefix: &str,
        pose: &Transform<f64>,
    ) -> Result<&mut Self, EditError> {
        let (link, placement) = self.find_frame(frame)?;
        // A robot that floats by itself needs no inertia where it is welded.
        other.clone().with_base(Base::Fixed).build()?;
        let root = format!("{prefix}{}", other.walk()[0].link.name);
        let mut joined = self.clone();
        let mut other = other.with_prefix(prefix);
        other.overrides.retain(|edit| edit.joint.is_some());
        joined.agree_on_mimicry(&mut other);
        joined.append(&other);
        let name = format!("{prefix}{ATTACHMENT}");
        joined.add_joint(
            JointSpec::new(name, JointKind::Fixed, link, root).with_placement(placement * *pose),
        );
        joined.check_names()?;
        *self = joined;
        Ok(self)
    }

    /// Makes two robots agree on mimicry: where joints follow in one and are independent in the other, the latter have
    /// nothing to follow any more.
    pub(in crate::model) fn agree_on_mimicry(&mut self, other: &mut Self) {
        if self.mimicry != other.mimicry {
            for builder in [self, other] {
                if builder.mimicry == Mimicry::Independent {
                    builder.mimicry = Mimicry::Coupled;
                    let joints = builder.joints.iter_mut();
                    joints.for_each(|joint| joint.mimic = None);
                }
            }
        }
    }

    /// The parts with a prefix before every name.
    pub(in crate::model) fn with_prefix(&self, prefix: &str) -> Self {
        let rename = |name: &mut String| name.insert_str(0, prefix);
        let mut out = self.clone();
        for link in &mut out.links {
            rename(&mut link.name);
        }
        for joint in &mut out.joints {
            rename(&mut joint.name);
            rename(&mut joint.parent);
            rename(&mut joint.child);
            if let Some(mimic) = &mut joint.mimic {
                rename(&mut mimic.leader);
            }
        }
        for frame in &mut out.frames {
            rename(&mut frame.name);
            rename(&mut frame.link);
        }
        let of_joints = out.overrides.iter_mut();
        of_joints
            .filter_map(|edit| edit.joint.as_mut())
            .for_each(rename);
        out
    }

    /// Adds the parts of another robot.
    pub(in crate::model) fn append(&mut self, other: &Self) {
        self.links.extend_from_slice(&other.links);
        self.joints.extend_from_slice(&other.joints);
        self.frames.extend_from_slice(&other.frames);
        self.overrides.extend_from_slice(&other.overrides);
    }

    fn check_names(&self) -> Result<(), EditError> {
        let links = self.links.iter().map(|link| &link.name);
        let frames = links.chain(self.frames.iter().map(|frame| &frame.name));
        unique("link or frame", frames)?;
        unique("joint", self.joints.iter().map(|joint| &joint.name))
    }

    /// The link that carries a frame, and the frame's pose in it.
    pub(in crate::model) fn find_frame(
        &self,
        name: &str,
    ) -> Result<(String, Transform<f64>), UnknownName> {
        if let Some(frame) = self.frames.iter().find(|frame| frame.name == name) {
            return Ok((frame.link.clone(), frame.placement));
        }
        if self.links.iter().any(|link| link.name == name) {
            return Ok((name.to_owned(), Transform::identity()));
        }
        let links = self.links.iter().map(|link| link.name.as_str());
        let known = links.chain(self.frames.iter().map(|frame| frame.name.as_str()));
        Err(self.unknown("frame", name, known))
    }
}

fn unique<'a>(element: &str, names: impl Iterator<Item = &'a String>) -> Result<(), EditError> {
    let mut seen = HashSet::new();
    for name in names {
        if !seen.insert(name) {
            return Err(EditError::DuplicateName {
                element: element.into(),
                name: name.clone(),
            });
        }
    }
    Ok(())
}

impl Model<f64> {
    /// Returns the robot with another one welded to a frame; see [`ModelBuilder::attach`].
    ///
    /// # Errors
    /// As there.
    pub fn with_attached(
        &self,
        other: &Self,
        frame: &str,
        prefix: &str,
        pose: &Transform<f64>,
    ) -> Result<Self, EditError> {
        let mut builder = self.to_builder();
        Ok(builder
            .attach(&other.to_builder(), frame, prefix, pose)?
            .build()?)
    }

    /// Returns the robot with an additional frame, at a pose in an existing frame or link.
    ///
    /// # Errors
    /// If there is no such frame, or the name is taken.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{model::samples, spatial::Transform};
    ///
    /// let arm = samples::arm().with_frame("camera", "tool", &Transform::identity())?;
    /// assert!(arm.frame("camera").is_some());
    /// # Ok::<(), dualbody::error::EditError>(())
    /// ```
    pub fn with_frame(
        &self,
        name: &str,
        parent: &str,
        pose: &Transform<f64>,
    ) -> Result<Self, EditError> {
        let mut builder = self.to_builder();
        let (link, placement) = builder.find_frame(parent)?;
        Ok(builder.add_frame(name, link, placement * *pose).build()?)
    }

    /// Returns the robot with an additional link on an additional joint.
    ///
    /// # Errors
    /// If a name is taken, the joint's parent does not exist, or the link is not the joint's child.
    pub fn with_body(&self, link: LinkSpec, joint: JointSpec) -> Result<Self, EditError> {
        let mut builder = self.to_builder();
        Ok(builder.add_link(link).add_joint(joint).build()?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics;
    use crate::model::samples;
    use crate::spatial::Quaternion;
    use crate::tests::ROUNDING;
    use nalgebra::Vector3;

    fn pose() -> Transform<f64> {
        let rotation = Quaternion::exp(&Vector3::new(0.3, -0.4, 1.0)).to_matrix();
        Transform::new(rotation, Vector3::new(0.1, -0.2, 0.3))
    }

    // The tip of the attached arm: pose of the tool · pose of the attachment · pose of the tip in the arm alone.
    #[test]
    fn pose_on_an_attached_robot_equals_the_product_of_poses() {
        let (arm, mate) = (samples::arm(), samples::double_pendulum());
        let both = arm.with_attached(&mate, "tool", "mate_", &pose()).unwrap();
        assert_eq!(both.nv(), arm.nv() + mate.nv());
        let mass = arm.total_mass() + mate.total_mass();
        assert!((both.total_mass() - mass).abs() < 10.0 * ROUNDING);
        let (q_arm, q_mate) = ([0.1, -0.5, 0.9, 1.2, 0.3, -0.7, 0.2], [0.4, -0.8]);
        let q: Vec<f64> = q_arm.iter().chain(&q_mate).copied().collect();
        let at = |model: &Model, q: &[f64], frame| {
            dynamics::frame_pose(model, q, model.frame(frame).unwrap())
        };
        let expected = at(&arm, &q_arm, "tool") * pose() * at(&mate, &q_mate, "lower");
        let actual = at(&both, &q, "mate_lower");
        assert!((actual.rotation - expected.rotation).amax() < 10.0 * ROUNDING);
        assert!((actual.translation - expected.translation).amax() < 10.0 * ROUNDING);
    }

    #[test]
    fn attaching_twice_needs_two_prefixes() {
        let (arm, mate) = (samples::arm(), samples::pendulum());
        let once = arm.with_attached(&mate, "tool", "a_", &pose()).unwrap();
        let error = once.with_attached(&mate, "tool", "a_", &pose());
        assert!(matches!(error, Err(EditError::DuplicateName { .. })));
        let twice = once.with_attached(&mate, "tool", "b_", &pose()).unwrap();
        assert_eq!(twice.joint_names()[7..], ["a_pivot", "b_pivot"]);
        let error = arm.with_attached(&mate, "hand", "a_", &pose()).unwrap_err();
        assert!(
            error.to_string().contains("has no frame \"hand\""),
            "{error}"
        );
    }

    #[test]
    fn body_that_is_added_equals_the_same_body_built_in() {
        let mut builder = ModelBuilder::new("double_pendulum");
        builder.add_link(LinkSpec::new("world"));
        let double = samples::double_pendulum();
        let parts = double.to_builder();
        builder.add_link(parts.links[1].clone());
        builder.add_joint(parts.joints[0].clone());
        let single = builder.build().unwrap();
        let (link, joint) = (parts.links[2].clone(), parts.joints[1].clone());
        let rebuilt = single.with_body(link, joint).unwrap();
        assert_eq!(rebuilt.bodies(), double.bodies());
    }
}
