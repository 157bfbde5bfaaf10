//! The reader of the elements of a URDF.

use super::{pose, schema};
use crate::error::LoadError;
use crate::io::context::{Context, Node, child};
use crate::io::mesh_path::MeshFinder;
use crate::io::rotation::rotation_from_quaternion;
use crate::io::schema::check;
use crate::io::values::{Attributes, Values};
use crate::io::version::Version;
use crate::spatial::{Transform, roll_pitch_yaw};

/// Version of a file that states none.
const FIRST: Version = Version(1, 0);
/// The first that has quaternions.
const WITH_QUATERNIONS: Version = Version(1, 1);
/// The first version in which a missing limit means that there is none.
pub(super) const WITH_OPTIONAL_LIMITS: Version = Version(1, 2);

/// The reader on its way through a text.
#[derive(Debug)]
pub(super) struct Reader<'c, 'f> {
    pub(super) context: &'c mut Context<'f>,
    pub(super) version: Version,
    pub(super) meshes: &'c mut MeshFinder,
}

/// The version of a robot.
pub(super) fn version(context: &mut Context<'_>, robot: Node<'_>) -> Version {
    let Some(text) = robot.attribute("version") else {
        return FIRST;
    };
    Version::parse(text).unwrap_or_else(|| {
        let reason = format!("\"{text}\" is not a version of the URDF: taken as 1.0");
        context.warn(robot, reason);
        FIRST
    })
}

impl Reader<'_, '_> {
    /// An attribute that an element must have, and that must not be empty.
    pub(super) fn attribute<'a>(&self, node: Node<'a>, name: &str) -> Result<&'a str, LoadError> {
        let text = node.attribute(name).filter(|text| !text.is_empty());
        text.ok_or_else(|| self.context.missing(node, Attributes::called(name)))
    }

    /// A child element that an element must have.
    pub(super) fn child<'a>(&self, node: Node<'a>, name: &str) -> Result<Node<'a>, LoadError> {
        child(node, name).ok_or_else(|| {
            self.context
                .missing(node, format!("child element <{name}>"))
        })
    }

    /// Reads the pose of an element; where it has none, that of its parent.
    pub(super) fn origin(&mut self, node: Node<'_>) -> Result<Transform<f64>, LoadError> {
        let Some(origin) = child(node, "origin") else {
            return Ok(pose([0.0; 3], [0.0; 3]));
        };
        check(self.context, origin, &schema::ORIGIN)?;
        let xyz = Attributes::numbers(self.context, origin, "xyz")?.unwrap_or_default();
        let rpy = Attributes::numbers(self.context, origin, "rpy")?.unwrap_or_default();
        Ok(pose(xyz, self.quaternion(origin)?.unwrap_or(rpy)))
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
