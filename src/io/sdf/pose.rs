//! `<pose>`: six numbers or seven, in a frame.

use nalgebra::Vector3;

use super::reader::Reader;
use super::scene::Pose;
use super::values::{check_value, text_of, truth};
use super::version::{WITH_FRAMES, WITH_ROTATION_FORMATS};
use crate::error::LoadError;
use crate::io::context::{Context, Node, child};
use crate::io::rotation::{rotation_from_quaternion, rotation_from_rpy};
use crate::io::values::finite;
use crate::scalar::MapEach;
use crate::spatial::Transform;

impl Reader<'_, '_, '_> {
    /// The pose of an element; where there is none, that of its parent.
    pub(super) fn pose(&mut self, node: Node<'_>) -> Result<Pose, LoadError> {
        let Some(pose) = child(node, "pose") else {
            return Ok(Pose::identity());
        };
        let attributes = format!("{} degrees rotation_format", self.relation());
        check_value(&mut self.context, pose, &attributes)?;
        if self.version < WITH_ROTATION_FORMATS {
            for attribute in ["degrees", "rotation_format"] {
                if pose.has_attribute(attribute) {
                    let reason = format!(
                        "{attribute} is part of the SDF from version 1.9 on: read all the same"
                    );
                    self.context.warn(pose, reason);
                }
            }
        }
        let relative_to = pose
            .attribute(self.relation())
            .filter(|name| !name.is_empty());
        if relative_to.is_some() && self.version < WITH_FRAMES {
            let reason = "the SDF before version 1.7 leaves open what frame=\"…\" means: taken as relative_to";
            self.context.warn(pose, reason);
        }
        Ok(Pose {
            relative_to: relative_to.map(Into::into),
            value: pose_value(&self.context, pose)?,
        })
    }

    /// The attribute that names the frame of a pose.
    fn relation(&self) -> &'static str {
        if self.version < WITH_FRAMES {
            "frame"
        } else {
            "relative_to"
        }
    }
}

/// The value of a `<pose>`.
pub(in crate::io) fn pose_value(
    context: &Context<'_>,
    pose: Node<'_>,
) -> Result<Transform<f64>, LoadError> {
    let text = text_of(pose);
    let format = pose.attribute("rotation_format");
    let degrees = pose.attribute("degrees");
    let degrees = truth(context, pose, "degrees", degrees.unwrap_or_default())?;
    match format.unwrap_or("euler_rpy") {
        _ if text.is_empty() => Ok(Transform::identity()),
        "euler_rpy" => {
            let [x, y, z, angles @ ..] = finite::<6>(context, pose, "pose", &text)?;
            let angles = if degrees {
                angles.map_each(f64::to_radians)
            } else {
                angles
            };
            Ok(Transform::new(
                rotation_from_rpy(angles),
                Vector3::new(x, y, z),
            ))
        }
        "quat_xyzw" if degrees => {
            let reason = "a quaternion has no degrees";
            Err(context.malformed(pose, "degrees", reason))
        }
        "quat_xyzw" => pose_of_quaternion(context, pose, &text),
        _ => {
            let reason = "expected euler_rpy or quat_xyzw";
            Err(context.malformed(pose, "rotation_format", reason))
        }
    }
}

fn pose_of_quaternion(
    context: &Context<'_>,
    pose: Node<'_>,
    text: &str,
) -> Result<Transform<f64>, LoadError> {
    let [p_x, p_y, p_z, xyzw @ ..] = finite::<7>(context, pose, "pose", text)?;
    let Some(rotation) = rotation_from_quaternion(xyzw) else {
        let reason = "the norm of the quaternion is zero";
        return Err(context.malformed_value(pose, "pose", text, reason));
    };
    Ok(Transform::new(rotation, Vector3::new(p_x, p_y, p_z)))
}
