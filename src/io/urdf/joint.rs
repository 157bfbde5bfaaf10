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

use super::parts::JointPart;
use super::reader::{Reader, WITH_OPTIONAL_LIMITS};
use super::schema;
use crate::error::LoadError;
use crate::io::context::{Context, Node, child};
use crate::io::motion::{
    Axis, Bound, bound, check_room, is_bounded, one_of, read_dynamics, read_mimic,
};
use crate::io::place::Place;
use crate::io::schema::check;
use crate::io::values::{Attributes, Values};
use crate::joint::JointKind;
use crate::model::{JointSpec, Limits, Mimic};

/// The kinds by their names in a URDF.
const KINDS: [(&str, JointKind); 7] = [
    ("revolute", JointKind::Revolute),
    ("continuous", JointKind::Continuous),
    ("prismatic", JointKind::Prismatic),
    ("fixed", JointKind::Fixed),
    ("floating", JointKind::Floating),
    ("planar", JointKind::Planar),
    ("spherical", JointKind::Spherical),
];

/// Default axis of a joint.
pub(super) const DEFAULT_AXIS: [f64; 3] = [1.0, 0.0, 0.0];

/// Remark on motion settings of a fixed joint.
pub(super) const DOES_NOT_MOVE: &str = "a fixed joint does not move";

/// Remark on a joint that should have limits of position.
pub(super) const NO_LIMIT: &str = "no <limit>: taken as unlimited";

/// Reads a joint.
pub(super) fn read<'a>(
    reader: &mut Reader<'_, '_>,
    node: Node<'a>,
) -> Result<JointPart<'a>, LoadError> {
    check(reader.context, node, &schema::JOINT)?;
    let name = reader.attribute(node, "name")?;
    let kind = *one_of(reader.context, node, "type", &KINDS)?;
    let placement = reader.origin(node)?;
    let parent = read_link(reader, node, "parent")?;
    let child = read_link(reader, node, "child")?;
    let spec = JointSpec::new(name, kind, parent, child).with_placement(placement);
    let (spec, mimic) = if kind == JointKind::Fixed {
        ignore_motion(reader, node);
        (spec, None)
    } else {
        let axis = read_axis(reader, node, kind)?;
        (spec.along(axis), read_leader(reader, node)?)
    };
    let place = node.into();
    Ok(JointPart {
        name,
        place,
        spec,
        mimic,
    })
}

/// Remarks on limits that may not mean what their author wanted.
pub(super) fn check_limits(context: &mut Context<'_>, place: Place<'_>, limits: &Limits) {
    check_room(context, place, limits);
    for (quantity, limit) in [("velocity", limits.velocity), ("effort", limits.effort)] {
        if limit == Some(0.0) {
            context.warn(place, format!("{quantity} is limited to 0"));
        }
    }
}

fn read_link<'a>(
    reader: &mut Reader<'_, '_>,
    joint: Node<'a>,
    end: &str,
) -> Result<&'a str, LoadError> {
    let node = reader.child(joint, end)?;
    check(reader.context, node, &schema::LINK_REFERENCE)?;
    reader.attribute(node, "link")
}

fn ignore_motion(reader: &mut Reader<'_, '_>, node: Node<'_>) {
    for element in ["axis", "limit", "dynamics", "mimic"] {
        if let Some(element) = child(node, element) {
            reader.context.ignore(element, DOES_NOT_MOVE);
        }
    }
}

fn read_axis(
    reader: &mut Reader<'_, '_>,
    joint: Node<'_>,
    kind: JointKind,
) -> Result<Axis, LoadError> {
    let mut axis = Axis::about(read_direction(reader, joint, kind)?);
    axis.limits = read_limits(reader, joint, kind)?;
    if let Some(dynamics) = child(joint, "dynamics") {
        check(reader.context, dynamics, &schema::DYNAMICS)?;
        read_dynamics::<Attributes>(reader.context, dynamics, &mut axis)?;
    }
    Ok(axis)
}

fn read_direction(
    reader: &mut Reader<'_, '_>,
    joint: Node<'_>,
    kind: JointKind,
) -> Result<[f64; 3], LoadError> {
    match child(joint, "axis") {
        Some(axis) if kind.has_axis() => {
            check(reader.context, axis, &schema::AXIS)?;
            return Attributes::required(reader.context, axis, "xyz");
        }
        Some(axis) => reader.context.ignore(axis, "the joint has no axis"),
        None if kind.has_axis() => reader.context.warn(joint, "no <axis>: taken as 1 0 0"),
        None => {}
    }
    Ok(DEFAULT_AXIS)
}

fn read_limits(
    reader: &mut Reader<'_, '_>,
    joint: Node<'_>,
    kind: JointKind,
) -> Result<Limits, LoadError> {
    let Some(limit) = child(joint, "limit") else {
        if is_bounded(kind) {
            reader.context.warn(joint, NO_LIMIT);
        }
        return Ok(Limits::default());
    };
    check(reader.context, limit, &schema::LIMIT)?;
    let mut limits = Limits::default();
    if is_bounded(kind) {
        limits.lower = read_limit(reader, limit, "lower", -1.0)?;
        limits.upper = read_limit(reader, limit, "upper", 1.0)?;
    } else {
        ignore_positions(reader, limit);
    }
    limits.velocity = read_limit(reader, limit, "velocity", 1.0)?;
    limits.effort = read_limit(reader, limit, "effort", 1.0)?;
    check_limits(reader.context, limit.into(), &limits);
    Ok(limits)
}

/// Reads one limit; `side` is the sign of the side on which it is.
fn read_limit(
    reader: &mut Reader<'_, '_>,
    limit: Node<'_>,
    name: &str,
    side: f64,
) -> Result<Option<f64>, LoadError> {
    let text = limit.attribute(name);
    let is_position = matches!(name, "lower" | "upper");
    let (value, reason) = match bound(reader.context, limit, name, text, [side, f64::INFINITY])? {
        Bound::Finite(x) => return Ok(Some(x)),
        Bound::Absent if reader.version >= WITH_OPTIONAL_LIMITS => return Ok(None),
        Bound::Absent if is_position => (
            Some(0.0),
            format!("no {name}: taken as 0, as the URDF before version 1.2 says"),
        ),
        Bound::Absent => (None, format!("no {name}: taken as unlimited")),
        Bound::Infinite => (None, format!("{name} is infinite: taken as unlimited")),
    };
    reader.context.warn(limit, reason);
    Ok(value)
}

fn ignore_positions(reader: &mut Reader<'_, '_>, limit: Node<'_>) {
    for end in ["lower", "upper"] {
        if limit.attribute(end).is_some() {
            let reason = "a joint of this kind has no limits of position";
            reader.context.ignore_attribute(limit, end, reason);
        }
    }
}

fn read_leader<'a>(
    reader: &mut Reader<'_, '_>,
    joint: Node<'a>,
) -> Result<Option<(Place<'a>, Mimic)>, LoadError> {
    let Some(node) = child(joint, "mimic") else {
        return Ok(None);
    };
    check(reader.context, node, &schema::MIMIC)?;
    let mimic = read_mimic::<Attributes>(reader.context, node)?;
    Ok(Some((node.into(), mimic)))
}
