//! Reads joints: kind, links, axis, limits, friction, mimicry.
//!
//! | `<limit>` of a revolute or prismatic joint | read as |
//! |---|---|
//! | is missing (the URDF demands it) | no limits, with a warning |
//! | has no `lower` or `upper` | 0, as the URDF says, with a warning; from version 1.2 of the URDF on: no limit |
//! | has no `effort` or `velocity` (the URDF demands them) | no limit, with a warning; from version 1.2 on without |
//! | a value is infinite | no limit, with a warning |
//!
//! Joints of other kinds have limits of effort and velocity only.

use urdf_rs::{JointLimit, JointType};

use super::reader::{Reader, WITH_OPTIONAL_LIMITS};
use super::schema;
use crate::error::LoadError;
use crate::io::context::{Node, child};
use crate::io::schema::check;
use crate::io::values::{Attributes, Values, any};
use crate::joint::JointKind;

/// The kinds by their names in a URDF.
const KINDS: [(&str, JointType); 7] = [
    ("revolute", JointType::Revolute),
    ("continuous", JointType::Continuous),
    ("prismatic", JointType::Prismatic),
    ("fixed", JointType::Fixed),
    ("floating", JointType::Floating),
    ("planar", JointType::Planar),
    ("spherical", JointType::Spherical),
];

/// Reads a joint.
pub(super) fn read(
    reader: &mut Reader<'_, '_>,
    node: Node<'_>,
) -> Result<urdf_rs::Joint, LoadError> {
    check(reader.context, node, &schema::JOINT)?;
    let name = reader.attribute(node, "name")?;
    let mut joint = urdf_rs::Joint {
        name,
        joint_type: read_kind(reader, node)?,
        origin: reader.origin(node)?,
        parent: read_link(reader, node, "parent")?,
        child: read_link(reader, node, "child")?,
        axis: urdf_rs::Axis::default(),
        limit: unlimited(),
        calibration: None,
        dynamics: None,
        mimic: None,
        safety_controller: None,
    };
    let kind = kind(&joint.joint_type);
    if kind == JointKind::Fixed {
        ignore_motion(reader, node);
    } else {
        joint.axis = read_axis(reader, node, kind)?;
        joint.limit = read_limits(reader, node, kind)?;
        joint.dynamics = read_dynamics(reader, node)?;
        joint.mimic = read_mimic(reader, node)?;
    }
    Ok(joint)
}

/// The kind of the model's joint.
pub(super) fn kind(of: &JointType) -> JointKind {
    match of {
        JointType::Revolute => JointKind::Revolute,
        JointType::Continuous => JointKind::Continuous,
        JointType::Prismatic => JointKind::Prismatic,
        JointType::Fixed => JointKind::Fixed,
        JointType::Floating => JointKind::Floating,
        JointType::Planar => JointKind::Planar,
        JointType::Spherical => JointKind::Spherical,
    }
}

/// Whether joints of a kind have limits of position.
pub(super) fn is_bounded(kind: JointKind) -> bool {
    matches!(kind, JointKind::Revolute | JointKind::Prismatic)
}

/// Limits that bound nothing.
pub(super) fn unlimited() -> JointLimit {
    JointLimit {
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
        velocity: f64::INFINITY,
        effort: f64::INFINITY,
        ..JointLimit::default()
    }
}

fn read_kind(reader: &mut Reader<'_, '_>, node: Node<'_>) -> Result<JointType, LoadError> {
    let text = reader.attribute(node, "type")?;
    let kind = KINDS.into_iter().find(|(name, _)| *name == text.trim());
    kind.map(|(_, kind)| kind).ok_or_else(|| {
        let names = KINDS.map(|(name, _)| name).join(", ");
        let reason = format!("expected one of {names}");
        reader.context.malformed(node, "type", reason)
    })
}

fn read_link(
    reader: &mut Reader<'_, '_>,
    joint: Node<'_>,
    end: &str,
) -> Result<urdf_rs::LinkName, LoadError> {
    let node = reader.child(joint, end)?;
    check(reader.context, node, &schema::LINK_REFERENCE)?;
    let link = reader.attribute(node, "link")?;
    Ok(urdf_rs::LinkName { link })
}

fn ignore_motion(reader: &mut Reader<'_, '_>, node: Node<'_>) {
    for element in ["axis", "limit", "dynamics", "mimic"] {
        if let Some(element) = child(node, element) {
            reader.context.ignore(element, DOES_NOT_MOVE);
        }
    }
}

/// Reason why no one reads how a fixed joint moves.
pub(super) const DOES_NOT_MOVE: &str = "a fixed joint does not move";

fn read_axis(
    reader: &mut Reader<'_, '_>,
    joint: Node<'_>,
    kind: JointKind,
) -> Result<urdf_rs::Axis, LoadError> {
    match child(joint, "axis") {
        Some(axis) if kind.has_axis() => {
            check(reader.context, axis, &schema::AXIS)?;
            let xyz = urdf_rs::Vec3(Attributes::required(reader.context, axis, "xyz")?);
            return Ok(urdf_rs::Axis { xyz });
        }
        Some(axis) => reader.context.ignore(axis, "the joint has no axis"),
        None if kind.has_axis() => reader.context.warn(joint, "no <axis>: taken as 1 0 0"),
        None => {}
    }
    Ok(urdf_rs::Axis::default())
}

fn read_limits(
    reader: &mut Reader<'_, '_>,
    joint: Node<'_>,
    kind: JointKind,
) -> Result<JointLimit, LoadError> {
    let mut limits = unlimited();
    let Some(limit) = child(joint, "limit") else {
        if is_bounded(kind) {
            reader.context.warn(joint, NO_LIMIT);
        }
        return Ok(limits);
    };
    check(reader.context, limit, &schema::LIMIT)?;
    if is_bounded(kind) {
        let lower = bound(reader, limit, "lower", f64::NEG_INFINITY)?;
        let upper = bound(reader, limit, "upper", f64::INFINITY)?;
        limits.lower = read_position(reader, limit, "lower", lower).unwrap_or(limits.lower);
        limits.upper = read_position(reader, limit, "upper", upper).unwrap_or(limits.upper);
    } else {
        ignore_positions(reader, limit);
    }
    limits.velocity = read_magnitude(reader, limit, "velocity")?;
    limits.effort = read_magnitude(reader, limit, "effort")?;
    Ok(limits)
}

/// Remark on a joint that should have limits of position.
pub(super) const NO_LIMIT: &str = "no <limit>: taken as unlimited";

/// A limit that may be infinite towards one side.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Bound {
    /// The attribute is absent.
    Absent,
    /// A finite number.
    Finite(f64),
    /// Infinite: no bound at all.
    Infinite,
}

/// The bound of an attribute, which may be `no_bound`, an infinity.
fn bound(
    reader: &mut Reader<'_, '_>,
    node: Node<'_>,
    attribute: &str,
    no_bound: f64,
) -> Result<Bound, LoadError> {
    let Some(text) = node.attribute(attribute) else {
        return Ok(Bound::Absent);
    };
    let [x] = any(reader.context, node, attribute, text)?;
    match x {
        _ if x == no_bound => Ok(Bound::Infinite),
        _ if x.is_finite() => Ok(Bound::Finite(x)),
        _ => Err(reader.context.non_finite(node, attribute)),
    }
}

/// The value of an end of the range, if there is one.
fn read_position(
    reader: &mut Reader<'_, '_>,
    limit: Node<'_>,
    end: &str,
    bound: Bound,
) -> Option<f64> {
    match bound {
        Bound::Finite(x) => Some(x),
        Bound::Absent if reader.version >= WITH_OPTIONAL_LIMITS => None,
        Bound::Absent => {
            let reason = format!("no {end}: taken as 0, as the URDF before version 1.2 says");
            reader.context.warn(limit, reason);
            Some(0.0)
        }
        Bound::Infinite => {
            let reason = format!("{end} is infinite: taken as unlimited");
            reader.context.warn(limit, reason);
            None
        }
    }
}

fn ignore_positions(reader: &mut Reader<'_, '_>, limit: Node<'_>) {
    for end in ["lower", "upper"] {
        if limit.attribute(end).is_some() {
            let reason = "a joint of this kind has no limits of position";
            reader.context.ignore_attribute(limit, end, reason);
        }
    }
}

/// Reads a limit of velocity or effort; infinite where there is none.
fn read_magnitude(
    reader: &mut Reader<'_, '_>,
    limit: Node<'_>,
    quantity: &str,
) -> Result<f64, LoadError> {
    let remark = match bound(reader, limit, quantity, f64::INFINITY)? {
        Bound::Finite(x) => return Ok(x),
        Bound::Absent if reader.version >= WITH_OPTIONAL_LIMITS => return Ok(f64::INFINITY),
        Bound::Absent => format!("no {quantity}: taken as unlimited"),
        Bound::Infinite => format!("{quantity} is infinite: taken as unlimited"),
    };
    reader.context.warn(limit, remark);
    Ok(f64::INFINITY)
}

fn read_dynamics(
    reader: &mut Reader<'_, '_>,
    joint: Node<'_>,
) -> Result<Option<urdf_rs::Dynamics>, LoadError> {
    let Some(node) = child(joint, "dynamics") else {
        return Ok(None);
    };
    check(reader.context, node, &schema::DYNAMICS)?;
    Ok(Some(urdf_rs::Dynamics {
        damping: Attributes::number(reader.context, node, "damping")?.unwrap_or_default(),
        friction: Attributes::number(reader.context, node, "friction")?.unwrap_or_default(),
    }))
}

fn read_mimic(
    reader: &mut Reader<'_, '_>,
    joint: Node<'_>,
) -> Result<Option<urdf_rs::Mimic>, LoadError> {
    let Some(node) = child(joint, "mimic") else {
        return Ok(None);
    };
    check(reader.context, node, &schema::MIMIC)?;
    Ok(Some(urdf_rs::Mimic {
        joint: reader.attribute(node, "joint")?,
        multiplier: Attributes::number(reader.context, node, "multiplier")?,
        offset: Attributes::number(reader.context, node, "offset")?,
    }))
}
