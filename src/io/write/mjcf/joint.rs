//! Joints in the kinds that `MuJoCo` has.

use nalgebra::Vector3;

use super::{Writer, number, numbers, unsupported};
use crate::error::WriteError;
use crate::io::write::FLOATING_BASE;
use crate::joint::{Joint, JointKind, Pitch};
use crate::model::{JointSpec, Limits, SecondAxis, unit};
use crate::spatial::Transform;

/// End of a range that is not limited, rad or m.
const UNLIMITED: f64 = 1e9;

impl Writer<'_> {
    pub(super) fn floating_base(&mut self) -> Result<(), WriteError> {
        let name = self.joint_names.fresh(FLOATING_BASE);
        if self.builder.has_override(None) {
            return Err(unsupported(
                "joint",
                &name,
                "damping or armature of the floating base",
            ));
        }
        self.xml.leaf("freejoint", &[("name", &name)]);
        Ok(())
    }

    /// Writes a joint; `on_world` says whether the world itself carries it.
    pub(super) fn joint(&mut self, joint: &JointSpec, on_world: bool) -> Result<(), WriteError> {
        check(joint, self.builder.has_override(Some(&joint.name)))?;
        let name = &joint.name;
        match joint.kind {
            JointKind::Fixed => {}
            JointKind::Revolute | JointKind::Continuous => self.simple(joint, "hinge"),
            JointKind::Prismatic => self.simple(joint, "slide"),
            JointKind::Screw(pitch) => self.screw(joint, pitch),
            JointKind::Universal => self.universal(joint),
            JointKind::Spherical => self.one_of(joint, name, "ball", None),
            JointKind::Planar => {
                let axes = joint.motion_frame();
                let parts = [("x", "slide"), ("y", "slide"), ("angle", "hinge")];
                for ((part, kind), axis) in parts.into_iter().zip(axes.column_iter()) {
                    let name = self.joint_names.fresh(format!("{name}_{part}"));
                    self.one_of(joint, &name, kind, Some(axis.into_owned()));
                }
            }
            JointKind::Floating if on_world => self.one_of(joint, name, "free", None),
            JointKind::Floating => {
                for (k, part) in ["x", "y", "z"].into_iter().enumerate() {
                    let name = self.joint_names.fresh(format!("{name}_{part}"));
                    self.one_of(joint, &name, "slide", Some(Vector3::ith(k, 1.0)));
                }
                let name = self.joint_names.fresh(format!("{name}_rotation"));
                self.one_of(joint, &name, "ball", None);
            }
        }
        Ok(())
    }

    /// A hinge, and a slide along its axis that an equality constraint ties to it.
    fn screw(&mut self, joint: &JointSpec, pitch: Pitch) {
        self.simple(joint, "hinge");
        let slide = self.joint_names.fresh(format!("{}_advance", &joint.name));
        let mut attributes = vec![("name", slide.clone()), ("type", "slide".to_owned())];
        attributes.extend(self.placed(Some(unit(&joint.axis))));
        self.xml.leaf("joint", &attributes);
        self.screws.push((slide, joint.name.to_owned(), pitch));
    }

    /// Two hinges of one body.
    fn universal(&mut self, joint: &JointSpec) {
        self.simple(joint, "hinge");
        let Some(second) = joint.second.as_ref() else {
            return;
        };
        let name = self.joint_names.fresh(format!("{}_second", &joint.name));
        self.second_hinges
            .insert(joint.name.to_owned(), name.clone());
        let mut attributes = vec![("name", name), ("type", "hinge".to_owned())];
        attributes.extend(self.placed(Some(unit(&second.axis))));
        self.speed(&second.limits);
        attributes.extend(self.range(&second.limits));
        attributes.extend(passive(second));
        self.xml.leaf("joint", &attributes);
    }

    /// A joint of one degree of freedom.
    fn simple(&mut self, joint: &JointSpec, kind: &str) {
        self.one_of(joint, &joint.name, kind, Some(unit(&joint.axis)));
    }

    /// One of the joints that a joint becomes.
    fn one_of(&mut self, joint: &JointSpec, name: &str, kind: &str, axis: Option<Vector3<f64>>) {
        let mut attributes = vec![("name", name.to_owned()), ("type", kind.to_owned())];
        attributes.extend(self.placed(axis));
        self.speed(&joint.limits);
        if joint.kind.has_limits() {
            attributes.extend(self.range(&joint.limits));
        }
        attributes.extend(passive(&joint.first_axis()));
        self.xml.leaf("joint", &attributes);
    }

    /// The place and axis in the body of one of the joints that a joint becomes.
    fn placed(&self, axis: Option<Vector3<f64>>) -> impl Iterator<Item = (&'static str, String)> {
        let Transform {
            rotation,
            translation,
        } = self.shift;
        let origin = Some(translation).filter(|origin| *origin != Vector3::zeros());
        // Without the signs of zeros.
        let origin = origin.map(|origin| origin.add_scalar(0.0));
        let axis = axis.map(|axis| rotation * axis);
        let own = [("pos", origin), ("axis", axis)].into_iter();
        own.filter_map(|(name, x)| Some((name, numbers(x?.as_slice()))))
    }

    /// `MuJoCo` has no limits of speed.
    fn speed(&mut self, limits: &Limits) {
        if let Some(speed) = limits.velocity.filter(|speed| speed.is_finite()) {
            self.xml.comment(&format!(
                "left out: the speed limit {speed} of the next joint"
            ));
        }
    }

    fn range(&mut self, limits: &Limits) -> Option<(&'static str, String)> {
        if (limits.lower, limits.upper) == (None, None) {
            return None;
        }
        let (lower, upper) = (
            limits.lower.unwrap_or(-UNLIMITED),
            limits.upper.unwrap_or(UNLIMITED),
        );
        if lower == upper {
            self.xml.comment(&format!(
                "left out: the range {lower} to {upper} of the next joint"
            ));
            return None;
        }
        Some(("range", numbers(&[lower, upper])))
    }
}

/// Passive forces along a joint, where they are not zero.
fn passive(axis: &SecondAxis) -> impl Iterator<Item = (&'static str, String)> {
    let values = [
        ("damping", axis.damping),
        ("frictionloss", axis.friction),
        ("armature", axis.armature),
        ("stiffness", axis.spring.stiffness),
        ("springref", axis.spring.rest),
    ];
    let present = values.into_iter().filter(|(_, value)| *value != 0.0);
    present.map(|(attribute, value)| (attribute, number(value)))
}

/// Refuses properties of a joint that enter the dynamics and that MJCF cannot express.
fn check(joint: &JointSpec, has_override: bool) -> Result<(), WriteError> {
    let refuse = |reason| Err(unsupported("joint", &joint.name, reason));
    if has_override {
        return refuse("its axes differ in damping or armature");
    }
    if joint.kind.turns_with_body() && joint.armature != 0.0 {
        return refuse("its armature acts along axes of the body");
    }
    Ok(())
}
