//! The reader of the elements of a URDF.

use super::schema;
use crate::error::LoadError;
use crate::io::context::{Context, Node, child};
use crate::io::rotation::{roll_pitch_yaw, rotation_from_quaternion};
use crate::io::schema::check;
use crate::io::values::{Attributes, Values};
use crate::io::version::Version;

/// The first that has quaternions.
const WITH_QUATERNIONS: Version = Version(1, 1);
/// The first in which a limit that is not given is no limit.
pub(super) const WITH_OPTIONAL_LIMITS: Version = Version(1, 2);

/// The reader on its way through a text.
#[derive(Debug)]
pub(super) struct Reader<'c, 'f> {
    pub(super) context: &'c mut Context<'f>,
    pub(super) version: Version,
}

impl Reader<'_, '_> {
    pub(super) fn robot_name(&mut self, robot: Node<'_>) -> String {
        let name = robot.attribute("name").unwrap_or_else(|| {
            self.context.warn(robot, NAMELESS);
            DEFAULT_NAME
        });
        name.into()
    }

    /// An attribute that an element must have, and that must not be empty.
    pub(super) fn attribute(&mut self, node: Node<'_>, name: &str) -> Result<String, LoadError> {
        Ok(Attributes::required_text(self.context, node, name)?.into_owned())
    }

    /// A child element that an element must have.
    pub(super) fn child<'a>(&self, node: Node<'a>, name: &str) -> Result<Node<'a>, LoadError> {
        child(node, name).ok_or_else(|| {
            self.context
                .missing(node, format!("child element <{name}>"))
        })
    }

    /// Reads the pose of an element; where it has none, that of what it stands in.
    pub(super) fn origin(&mut self, node: Node<'_>) -> Result<urdf_rs::Pose, LoadError> {
        let Some(origin) = child(node, "origin") else {
            return Ok(urdf_rs::Pose::default());
        };
        check(self.context, origin, &schema::ORIGIN)?;
        let xyz = Attributes::numbers(self.context, origin, "xyz")?.unwrap_or_default();
        let rpy = Attributes::numbers(self.context, origin, "rpy")?.unwrap_or_default();
        let rpy = self.quaternion(origin)?.unwrap_or(rpy);
        Ok(urdf_rs::Pose {
            xyz: urdf_rs::Vec3(xyz),
            rpy: urdf_rs::Vec3(rpy),
        })
    }

    /// The roll, pitch and yaw of a quaternion, if there is one.
    fn quaternion(&mut self, origin: Node<'_>) -> Result<Option<[f64; 3]>, LoadError> {
        const NAME: &str = "quat_xyzw";
        if origin.attribute(NAME).is_some() && self.version < WITH_QUATERNIONS {
            let reason = "read only if <robot> has version=\"1.1\" or later";
            self.context.ignore_attribute(origin, NAME, reason);
            return Ok(None);
        }
        let Some(xyzw) = Attributes::numbers(self.context, origin, NAME)? else {
            return Ok(None);
        };
        if origin.attribute("rpy").is_some() {
            return Err(self.context.malformed(origin, NAME, "there is an rpy too"));
        }
        let Some(rotation) = rotation_from_quaternion(xyzw) else {
            return Err(self.context.malformed(origin, NAME, "the norm is zero"));
        };
        Ok(Some(roll_pitch_yaw(&rotation)))
    }
}

/// Name of a robot without one.
pub(super) const DEFAULT_NAME: &str = "robot";

/// Remark on a robot without a name.
pub(super) const NAMELESS: &str = "the robot has no name: called \"robot\"";
