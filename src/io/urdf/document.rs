//! The first pass over a file: checks every element that matters, reports every one that does not, and writes the text that
//! the reader behind gets: known elements and attributes only, each at most once, every number checked.
//!
//! That reader, like the files themselves, does not tell an absent limit or inertia from one that is zero: what is present
//! is noted here.

use super::{joint, link, schema};
use crate::error::LoadError;
use crate::io::context::{Context, Node, child, children};
use crate::io::numbers::numbers;
use crate::io::rotation;
use crate::io::schema::check;
use crate::io::xml::Xml;
use crate::joint::JointKind;

/// A checked description.
#[derive(Debug)]
pub(super) struct Document<'a> {
    /// The description without anything that the model has no place for.
    pub(super) text: String,
    /// The links, in the order of the file and of the text.
    pub(super) links: Vec<LinkEntry<'a>>,
    /// The joints, in the order of the file and of the text.
    pub(super) joints: Vec<JointEntry<'a>>,
}

/// Parts of a `<link>` that the first pass keeps.
#[derive(Debug)]
pub(super) struct LinkEntry<'a> {
    pub(super) inertial: Option<Node<'a>>,
    /// The visuals that have a shape.
    pub(super) visuals: Vec<Node<'a>>,
    /// The collisions that have a shape.
    pub(super) collisions: Vec<Node<'a>>,
}

/// Parts of a `<joint>` that the first pass keeps.
#[derive(Debug)]
pub(super) struct JointEntry<'a> {
    pub(super) node: Node<'a>,
    pub(super) kind: JointKind,
    pub(super) limits: PresentLimits,
}

/// Which limits a joint has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct PresentLimits {
    pub(super) lower: bool,
    pub(super) upper: bool,
    pub(super) velocity: bool,
    pub(super) effort: bool,
}

/// A version of the URDF, major before minor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Version(u32, u32);

impl Version {
    /// Version of a file that states none.
    const FIRST: Self = Self(1, 0);
    /// The first that has quaternions.
    pub(super) const WITH_QUATERNIONS: Self = Self(1, 1);
    /// The first in which a limit that is not given is no limit.
    pub(super) const WITH_OPTIONAL_LIMITS: Self = Self(1, 2);
}

/// The first pass on its way through a file.
#[derive(Debug)]
pub(super) struct Pass<'c, 'f> {
    pub(super) context: &'c mut Context<'f>,
    pub(super) out: Xml,
    pub(super) version: Version,
}

/// Runs the first pass.
pub(super) fn read<'a>(
    context: &mut Context<'_>,
    robot: Node<'a>,
) -> Result<Document<'a>, LoadError> {
    check(context, robot, &schema::ROBOT)?;
    let version = version(context, robot);
    let mut pass = Pass {
        context,
        out: Xml::new(),
        version,
    };
    let name = pass.robot_name(robot);
    pass.out.start("robot", &[("name", name)]);
    let links = children(robot, "link").map(|node| link::read(&mut pass, node));
    let links = links.collect::<Result<_, _>>()?;
    let joints = children(robot, "joint").map(|node| joint::read(&mut pass, node));
    let joints = joints.collect::<Result<_, _>>()?;
    for material in children(robot, "material") {
        link::read_material(&mut pass, material)?;
    }
    pass.out.end();
    Ok(Document {
        text: pass.out.finish(),
        links,
        joints,
    })
}

fn version(context: &mut Context<'_>, robot: Node<'_>) -> Version {
    let Some(text) = robot.attribute("version") else {
        return Version::FIRST;
    };
    let version = text.trim().split_once('.').and_then(|(major, minor)| {
        let parsed = (major.parse().ok()?, minor.parse().ok()?);
        Some(Version(parsed.0, parsed.1))
    });
    version.unwrap_or_else(|| {
        let reason = format!("\"{text}\" is not a version of the URDF: taken as 1.0");
        context.warn(robot, reason);
        Version::FIRST
    })
}

impl Pass<'_, '_> {
    fn robot_name<'a>(&mut self, robot: Node<'a>) -> &'a str {
        robot.attribute("name").unwrap_or_else(|| {
            let reason = "the robot has no name: called \"robot\"";
            self.context.warn(robot, reason);
            "robot"
        })
    }

    /// The name that an element must have.
    pub(super) fn name<'a>(&self, node: Node<'a>) -> Result<&'a str, LoadError> {
        self.attribute(node, "name")
    }

    /// An attribute that an element must have, and that must not be empty.
    pub(super) fn attribute<'a>(&self, node: Node<'a>, name: &str) -> Result<&'a str, LoadError> {
        let value = node.attribute(name).filter(|value| !value.is_empty());
        value.ok_or_else(|| self.context.missing(node, format!("attribute {name}")))
    }

    /// A child element that an element must have.
    pub(super) fn child<'a>(&self, node: Node<'a>, name: &str) -> Result<Node<'a>, LoadError> {
        child(node, name).ok_or_else(|| {
            self.context
                .missing(node, format!("child element <{name}>"))
        })
    }

    /// Copies attributes that may be missing.
    pub(super) fn leaf(&mut self, tag: &str, node: Node<'_>, attributes: &[&str]) {
        let attributes: Vec<(&str, &str)> = attributes
            .iter()
            .filter_map(|&name| Some((name, node.attribute(name)?)))
            .collect();
        self.out.leaf(tag, &attributes);
    }

    /// Reads the pose of an element, if it has one.
    pub(super) fn origin(&mut self, node: Node<'_>) -> Result<(), LoadError> {
        let Some(origin) = child(node, "origin") else {
            return Ok(());
        };
        check(self.context, origin, &schema::ORIGIN)?;
        let xyz = numbers::<3>(self.context, origin, "xyz")?.unwrap_or_default();
        let rpy = numbers::<3>(self.context, origin, "rpy")?.unwrap_or_default();
        if let Some(rpy) = self.quaternion(origin)? {
            let xyz = origin.attribute("xyz").unwrap_or("0 0 0");
            self.out.leaf("origin", &[("xyz", xyz), ("rpy", &rpy)]);
        } else if (xyz, rpy) != ([0.0; 3], [0.0; 3]) {
            self.leaf("origin", origin, &["xyz", "rpy"]);
        }
        Ok(())
    }

    /// The roll, pitch and yaw of a quaternion, if there is one.
    fn quaternion(&mut self, origin: Node<'_>) -> Result<Option<String>, LoadError> {
        const NAME: &str = "quat_xyzw";
        if origin.attribute(NAME).is_some() && self.version < Version::WITH_QUATERNIONS {
            let reason = "read only if <robot> has version=\"1.1\" or later";
            self.context.ignore_attribute(origin, NAME, reason);
            return Ok(None);
        }
        let Some(xyzw) = numbers::<4>(self.context, origin, NAME)? else {
            return Ok(None);
        };
        if origin.attribute("rpy").is_some() {
            return Err(self.context.malformed(origin, NAME, "there is an rpy too"));
        }
        let Some([r, p, y]) = roll_pitch_yaw(xyzw) else {
            return Err(self.context.malformed(origin, NAME, "the norm is zero"));
        };
        Ok(Some(format!("{r:?} {p:?} {y:?}")))
    }
}

/// The angles of a quaternion of any norm but zero.
fn roll_pitch_yaw(xyzw: [f64; 4]) -> Option<[f64; 3]> {
    // Scaled first, so that no square vanishes or overflows.
    let largest = xyzw.iter().fold(0.0_f64, |max, x| max.max(x.abs()));
    if largest == 0.0 {
        return None;
    }
    let [x, y, z, w] = xyzw.map(|x| x / largest);
    let rotation = nalgebra::UnitQuaternion::new_normalize(nalgebra::Quaternion::new(w, x, y, z));
    let r = rotation.to_rotation_matrix();
    Some(rotation::roll_pitch_yaw(r.matrix()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Quaternion, Rotation3, UnitQuaternion};

    #[test]
    fn angles_of_a_quaternion_equal_its_rotation_even_when_pitch_is_a_right_angle() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let upright = [0.0, half, 0.0, half];
        for xyzw in [
            [0.1, -0.4, 0.3, 0.9],
            [2e200, -1e200, 0.0, 1e200],
            upright,
            [0.5, 0.5, -0.5, 0.5],
            [0.0, half + 1e-9, 0.0, half],
            [0.3, 0.639, -0.302, 0.64],
        ] {
            let [r, p, y] = roll_pitch_yaw(xyzw).unwrap();
            let largest = xyzw.iter().fold(0.0_f64, |max, x| max.max(x.abs()));
            let [qx, qy, qz, qw] = xyzw.map(|x| x / largest);
            let expected = UnitQuaternion::new_normalize(Quaternion::new(qw, qx, qy, qz));
            let error = Rotation3::from_euler_angles(r, p, y).matrix()
                - expected.to_rotation_matrix().matrix();
            assert!(error.amax() < 1e-15 * 4.0, "{xyzw:?}: {error}");
        }
        assert_eq!(roll_pitch_yaw([0.0; 4]), None);
    }
}
