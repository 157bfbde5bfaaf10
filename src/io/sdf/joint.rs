//! Joints: kind, ends, axes, limits, friction, springs, mimicry.
//!
//! | `type` | becomes |
//! |---|---|
//! | `revolute`, `continuous`, `prismatic`, `fixed` | the joint of that kind |
//! | `ball` | a spherical joint |
//! | `screw` | a screw joint; the position is the angle |
//! | `universal`, `revolute2` | a universal joint; two joints `NAME::axis` and `NAME::axis2`, continuous where they have no limits, if one of them follows or leads, or the axes are parallel |
//! | `gearbox` | an error: it couples motions |
//!
//! A screw advances by `<screw_thread_pitch>`, m per turn, positive for a right-handed thread. The older `<thread_pitch>` counts the other way:
//! rad/m, positive for a left-handed thread. The former counts if there are both; where neither is, its default, 1 m per turn.

use super::reader::{Reader, attribute};
use super::scene::{Follow, FrameKind, JointEntry, Motion};
use super::schema;
use super::values::{self, Elements, check_value, magnitude, text_of};
use super::version::{WITH_FRAMES, WITH_MIMICS};
use crate::error::LoadError;
use crate::io::context::{Node, child};
use crate::io::motion::{Axis, check_room, one_of, read_dynamics, read_mimic};
use crate::io::schema::check;
use crate::io::sensors::Carrier;
use crate::io::values::{Values, finite};
use crate::joint::{JointKind, Pitch};
use crate::model::{Limits, Spring};

/// The types with the kinds of their motions, from the parent to the child.
const TYPES: [(&str, &[JointKind]); 8] = [
    ("revolute", &[JointKind::Revolute]),
    ("continuous", &[JointKind::Continuous]),
    ("prismatic", &[JointKind::Prismatic]),
    ("fixed", &[]),
    ("ball", &[JointKind::Spherical]),
    ("screw", &[JointKind::Screw(Pitch::per_radian(0.0))]),
    ("universal", &[JointKind::Revolute, JointKind::Revolute]),
    ("revolute2", &[JointKind::Revolute, JointKind::Revolute]),
];

/// The elements of the axes.
const AXES: [&str; 2] = ["axis", "axis2"];

impl Reader<'_, '_, '_> {
    /// Reads a joint into a scope.
    pub(super) fn joint(&mut self, node: Node<'_>, scope: usize) -> Result<(), LoadError> {
        check(&mut self.context, node, &schema::JOINT)?;
        let name = self.name(node)?;
        let kinds = self.joint_kinds(node)?;
        let pose = self.pose(node)?;
        let parent = Elements::required_text(&mut self.context, node, "parent")?.into_owned();
        let child_name = Elements::required_text(&mut self.context, node, "child")?.into_owned();
        let mut motions = Vec::new();
        for (i, element) in AXES.into_iter().enumerate() {
            let axis = child(node, element);
            match (kinds.get(i), axis) {
                (Some(&JointKind::Screw(_)), _) => {
                    let kind = JointKind::Screw(self.pitch(node)?);
                    motions.push(self.motion(node, kind, axis)?);
                }
                (Some(&kind), _) if kind.has_axis() => motions.push(self.motion(node, kind, axis)?),
                (Some(&kind), axis) => motions.push(self.ball(kind, axis)?),
                (None, Some(axis)) => self.context.ignore(axis, "the joint has no such axis"),
                (None, None) => {}
            }
        }
        let kind = FrameKind::Joint(self.shared.scene.joints.len());
        let frame = self.add_frame(node, scope, &name, kind, pose)?;
        self.sensors(node, scope, Carrier::Joint, frame)?;
        let joint = JointEntry {
            frame,
            parent,
            child: child_name,
            motions,
        };
        self.shared.scene.joints.push(joint);
        Ok(())
    }

    fn joint_kinds(&mut self, node: Node<'_>) -> Result<&'static [JointKind], LoadError> {
        if node
            .attribute("type")
            .is_some_and(|text| text.trim() == "gearbox")
        {
            let reason = "joints of type gearbox couple motions, which is not modelled";
            return Err(self.unsupported(node, reason));
        }
        one_of(&mut self.context, node, "type", &TYPES).copied()
    }

    /// The pitch of a screw.
    fn pitch(&mut self, joint: Node<'_>) -> Result<Pitch, LoadError> {
        let context = &mut self.context;
        let by_turn = Elements::number(context, joint, "screw_thread_pitch")?;
        let by_metre = Elements::number(context, joint, "thread_pitch")?;
        match (by_turn, by_metre) {
            (Some(metres), Some(radians)) => {
                let reason = format!(
                    "<screw_thread_pitch> {metres} m per turn is read, <thread_pitch> {radians} rad per metre is not"
                );
                context.warn(joint, reason);
                Ok(Pitch::per_turn(metres))
            }
            (Some(metres), None) => Ok(Pitch::per_turn(metres)),
            (None, Some(0.0)) => {
                let reason = "0 rad/m is no thread: it would advance without a turn";
                Err(context.malformed(joint, "thread_pitch", reason))
            }
            (None, Some(radians)) => Ok(Pitch::per_radian(-1.0 / radians)),
            (None, None) => {
                context.warn(joint, "no <screw_thread_pitch>: taken as 1 m per turn");
                Ok(Pitch::per_turn(1.0))
            }
        }
    }

    /// A joint without axis has friction only.
    fn ball(&mut self, kind: JointKind, axis: Option<Node<'_>>) -> Result<Motion, LoadError> {
        let mut motion = Motion::of(kind);
        if let Some(axis) = axis {
            self.context
                .ignore(axis, "the joint has no axis; only its dynamics are read");
            self.dynamics(axis, &mut motion.axis)?;
        }
        Ok(motion)
    }

    fn motion(
        &mut self,
        joint: Node<'_>,
        kind: JointKind,
        axis: Option<Node<'_>>,
    ) -> Result<Motion, LoadError> {
        let mut motion = Motion::of(kind);
        let Some(axis) = axis else {
            self.context
                .warn(joint, "no axis: taken as 0 0 1 without limits");
            motion.kind = without_limits(kind);
            return Ok(motion);
        };
        let known = if self.version < WITH_FRAMES {
            &schema::OLD_AXIS
        } else {
            &schema::AXIS
        };
        check(&mut self.context, axis, known)?;
        self.direction(axis, &mut motion)?;
        motion.axis.limits = self.limits(axis, kind)?;
        // The two axes of a universal joint rotate freely by default.
        let is_one_of_two = matches!(joint.attribute("type"), Some("universal" | "revolute2"));
        let limits = &motion.axis.limits;
        if is_one_of_two && (limits.lower, limits.upper) == (None, None) {
            motion.kind = without_limits(kind);
        }
        self.dynamics(axis, &mut motion.axis)?;
        motion.mimic = self.mimic(axis)?;
        Ok(motion)
    }

    /// Reads the axis and the frame that it is given in.
    fn direction(&mut self, axis: Node<'_>, motion: &mut Motion) -> Result<(), LoadError> {
        if let Some(xyz) = child(axis, "xyz") {
            let has_frames = self.version >= WITH_FRAMES;
            let attributes = if has_frames { "expressed_in" } else { "" };
            check_value(&mut self.context, xyz, attributes)?;
            let direction: [f64; 3] = finite(&self.context, axis, "xyz", &text_of(xyz))?;
            motion.axis.axis = direction.into();
            motion.expressed_in = attribute(xyz, "expressed_in").filter(|_| has_frames);
        } else {
            self.context.warn(axis, "no <xyz>: taken as 0 0 1");
        }
        if self.version < WITH_FRAMES
            && self
                .flag(axis, "use_parent_model_frame")?
                .unwrap_or_default()
        {
            motion.expressed_in = Some("__model__".into());
        }
        Ok(())
    }

    fn limits(&mut self, axis: Node<'_>, kind: JointKind) -> Result<Limits, LoadError> {
        let Some(limit) = child(axis, "limit") else {
            return Ok(Limits::default());
        };
        let context = &mut self.context;
        check(context, limit, &schema::LIMIT)?;
        let mut limits = Limits {
            lower: values::limit(context, limit, "lower", -1.0)?,
            upper: values::limit(context, limit, "upper", 1.0)?,
            velocity: magnitude(context, limit, "velocity")?,
            effort: magnitude(context, limit, "effort")?,
        };
        if kind == JointKind::Continuous {
            for (end, value) in [("lower", &mut limits.lower), ("upper", &mut limits.upper)] {
                if let (Some(_), Some(node)) = (value.take(), child(limit, end)) {
                    context.ignore(node, "a continuous joint has no limits of position");
                }
            }
        }
        check_room(context, limit.into(), &limits);
        Ok(limits)
    }

    /// Reads damping, friction and spring.
    fn dynamics(&mut self, element: Node<'_>, axis: &mut Axis) -> Result<(), LoadError> {
        let Some(dynamics) = child(element, "dynamics") else {
            return Ok(());
        };
        let context = &mut self.context;
        check(context, dynamics, &schema::DYNAMICS)?;
        read_dynamics::<Elements>(context, dynamics, axis)?;
        axis.spring = Spring {
            stiffness: Elements::number(context, dynamics, "spring_stiffness")?.unwrap_or_default(),
            rest: Elements::number(context, dynamics, "spring_reference")?.unwrap_or_default(),
        };
        Ok(())
    }

    fn mimic(&mut self, axis: Node<'_>) -> Result<Option<Follow>, LoadError> {
        let Some(mimic) = child(axis, "mimic").filter(|_| self.version >= WITH_FRAMES) else {
            return Ok(None);
        };
        if self.version < WITH_MIMICS {
            self.context
                .ignore(mimic, "read from version 1.11 of the SDF on");
            return Ok(None);
        }
        let context = &mut self.context;
        check(context, mimic, &schema::MIMIC)?;
        let axis = mimic.attribute("axis").unwrap_or("axis");
        let axis = AXES.iter().position(|name| *name == axis);
        Ok(Some(Follow {
            mimic: read_mimic::<Elements>(context, mimic)?,
            axis: axis.ok_or_else(|| context.malformed(mimic, "axis", "expected axis or axis2"))?,
            reference: Elements::number(context, mimic, "reference")?.unwrap_or_default(),
        }))
    }
}

impl Motion {
    /// A motion about z along which nothing acts.
    fn of(kind: JointKind) -> Self {
        Self {
            kind,
            axis: Axis::about([0.0, 0.0, 1.0]),
            expressed_in: None,
            mimic: None,
        }
    }
}

/// A joint that turns is continuous if it has no limits of position.
fn without_limits(kind: JointKind) -> JointKind {
    match kind {
        JointKind::Revolute => JointKind::Continuous,
        other => other,
    }
}
