//! First pass over joints: kind, links, axis, limits, friction, mimicry.
//!
//! | `<limit>` of a revolute or prismatic joint | read as |
//! |---|---|
//! | is missing (the URDF demands it) | no limits, with a warning |
//! | has no `lower` or `upper` | 0, as the URDF says, with a warning; from version 1.2 of the URDF on: no limit |
//! | has no `effort` or `velocity` (the URDF demands them) | no limit, with a warning; from version 1.2 on without |
//! | a value is infinite | no limit, with a warning |
//!
//! Joints of other kinds have limits of effort and velocity only.

use super::document::{JointEntry, Pass, PresentLimits, Version};
use super::schema;
use crate::error::LoadError;
use crate::io::context::{Node, child};
use crate::io::numbers::{Bound, bound, number, required};
use crate::io::schema::check;
use crate::joint::JointKind;

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

/// Reads a joint.
pub(super) fn read<'a>(
    pass: &mut Pass<'_, '_>,
    node: Node<'a>,
) -> Result<JointEntry<'a>, LoadError> {
    check(pass.context, node, &schema::JOINT)?;
    let name = pass.name(node)?;
    let (kind, kind_name) = read_kind(pass, node)?;
    pass.out
        .start("joint", &[("name", name), ("type", kind_name)]);
    pass.origin(node)?;
    read_link(pass, node, "parent")?;
    read_link(pass, node, "child")?;
    let mut limits = PresentLimits::default();
    if kind == JointKind::Fixed {
        ignore_motion(pass, node);
    } else {
        read_axis(pass, node, kind)?;
        limits = read_limits(pass, node, kind)?;
        read_dynamics(pass, node)?;
        read_mimic(pass, node)?;
    }
    pass.out.end();
    Ok(JointEntry { node, kind, limits })
}

fn read_kind(pass: &Pass<'_, '_>, node: Node<'_>) -> Result<(JointKind, &'static str), LoadError> {
    let text = pass.attribute(node, "type")?.trim();
    match KINDS.iter().find(|(name, _)| *name == text) {
        Some(&(name, kind)) => Ok((kind, name)),
        None => {
            let names = KINDS.map(|(name, _)| name).join(", ");
            let reason = format!("expected one of {names}");
            Err(pass.context.malformed(node, "type", reason))
        }
    }
}

fn read_link(pass: &mut Pass<'_, '_>, joint: Node<'_>, end: &str) -> Result<(), LoadError> {
    let node = pass.child(joint, end)?;
    check(pass.context, node, &schema::LINK_REFERENCE)?;
    let link = pass.attribute(node, "link")?;
    pass.out.leaf(end, &[("link", link)]);
    Ok(())
}

fn ignore_motion(pass: &mut Pass<'_, '_>, node: Node<'_>) {
    for element in ["axis", "limit", "dynamics", "mimic"] {
        if let Some(element) = child(node, element) {
            pass.context.ignore(element, "a fixed joint does not move");
        }
    }
}

fn read_axis(pass: &mut Pass<'_, '_>, joint: Node<'_>, kind: JointKind) -> Result<(), LoadError> {
    let axis = child(joint, "axis");
    match axis {
        Some(axis) if !kind.has_axis() => pass.context.ignore(axis, "the joint has no axis"),
        Some(axis) => {
            check(pass.context, axis, &schema::AXIS)?;
            required::<3>(pass.context, axis, "xyz")?;
            pass.leaf("axis", axis, &["xyz"]);
        }
        None if kind.has_axis() => pass.context.warn(joint, "no <axis>: taken as 1 0 0"),
        None => {}
    }
    Ok(())
}

fn read_limits(
    pass: &mut Pass<'_, '_>,
    joint: Node<'_>,
    kind: JointKind,
) -> Result<PresentLimits, LoadError> {
    let is_bounded = matches!(kind, JointKind::Revolute | JointKind::Prismatic);
    let Some(limit) = child(joint, "limit") else {
        if is_bounded {
            pass.context.warn(joint, "no <limit>: taken as unlimited");
        }
        return Ok(PresentLimits::default());
    };
    check(pass.context, limit, &schema::LIMIT)?;
    let (lower, upper) = if is_bounded {
        read_positions(pass, limit)?
    } else {
        ignore_positions(pass, limit);
        (false, false)
    };
    let present = PresentLimits {
        lower,
        upper,
        velocity: read_magnitude(pass, limit, "velocity")?,
        effort: read_magnitude(pass, limit, "effort")?,
    };
    if present != PresentLimits::default() {
        write_limits(pass, limit, present);
    }
    Ok(present)
}

/// Reads the range of positions; returns which ends there are.
fn read_positions(pass: &mut Pass<'_, '_>, limit: Node<'_>) -> Result<(bool, bool), LoadError> {
    let lower = bound(pass.context, limit, "lower", f64::NEG_INFINITY)?;
    let upper = bound(pass.context, limit, "upper", f64::INFINITY)?;
    let lower = read_position(pass, limit, "lower", lower);
    let upper = read_position(pass, limit, "upper", upper);
    if let (Some(lower), Some(upper)) = (lower, upper)
        && lower == upper
    {
        let reason = format!("lower = upper = {lower}: the limits leave no room to move");
        pass.context.warn(limit, reason);
    }
    Ok((lower.is_some(), upper.is_some()))
}

/// The value of an end of the range, if there is one.
fn read_position(pass: &mut Pass<'_, '_>, limit: Node<'_>, end: &str, bound: Bound) -> Option<f64> {
    match bound {
        Bound::Finite(x) => Some(x),
        Bound::Absent if pass.version >= Version::WITH_OPTIONAL_LIMITS => None,
        Bound::Absent => {
            let reason = format!("no {end}: taken as 0, as the URDF before version 1.2 says");
            pass.context.warn(limit, reason);
            Some(0.0)
        }
        Bound::Infinite => {
            let reason = format!("{end} is infinite: taken as unlimited");
            pass.context.warn(limit, reason);
            None
        }
    }
}

fn ignore_positions(pass: &mut Pass<'_, '_>, limit: Node<'_>) {
    for end in ["lower", "upper"] {
        if limit.attribute(end).is_some() {
            let reason = "a joint of this kind has no limits of position";
            pass.context.ignore_attribute(limit, end, reason);
        }
    }
}

/// Reads a limit of velocity or effort; returns whether there is one.
fn read_magnitude(
    pass: &mut Pass<'_, '_>,
    limit: Node<'_>,
    quantity: &str,
) -> Result<bool, LoadError> {
    let bound = bound(pass.context, limit, quantity, f64::INFINITY)?;
    let remark = match bound {
        Bound::Absent if pass.version < Version::WITH_OPTIONAL_LIMITS => {
            Some(format!("no {quantity}: taken as unlimited"))
        }
        Bound::Infinite => Some(format!("{quantity} is infinite: taken as unlimited")),
        Bound::Finite(0.0) => Some(format!("{quantity} is limited to 0")),
        _ => None,
    };
    if let Some(remark) = remark {
        pass.context.warn(limit, remark);
    }
    Ok(matches!(bound, Bound::Finite(_)))
}

/// Writes all four limits; the reader behind demands some of them.
fn write_limits(pass: &mut Pass<'_, '_>, limit: Node<'_>, present: PresentLimits) {
    let attributes = [
        ("lower", present.lower),
        ("upper", present.upper),
        ("velocity", present.velocity),
        ("effort", present.effort),
    ];
    let value = |name, present: bool| {
        let value = limit.attribute(name).filter(|_| present);
        (name, value.unwrap_or("0"))
    };
    pass.out.leaf(
        "limit",
        &attributes.map(|(name, present)| value(name, present)),
    );
}

fn read_dynamics(pass: &mut Pass<'_, '_>, joint: Node<'_>) -> Result<(), LoadError> {
    let Some(dynamics) = child(joint, "dynamics") else {
        return Ok(());
    };
    check(pass.context, dynamics, &schema::DYNAMICS)?;
    number(pass.context, dynamics, "damping")?;
    let friction = number(pass.context, dynamics, "friction")?.unwrap_or_default();
    if friction != 0.0 {
        let reason =
            format!("friction {friction} acts in simulators with Actuation::from_model only");
        pass.context.warn(dynamics, reason);
    }
    pass.leaf("dynamics", dynamics, &["damping", "friction"]);
    Ok(())
}

fn read_mimic(pass: &mut Pass<'_, '_>, joint: Node<'_>) -> Result<(), LoadError> {
    let Some(mimic) = child(joint, "mimic") else {
        return Ok(());
    };
    check(pass.context, mimic, &schema::MIMIC)?;
    pass.attribute(mimic, "joint")?;
    number(pass.context, mimic, "multiplier")?;
    number(pass.context, mimic, "offset")?;
    pass.leaf("mimic", mimic, &["joint", "multiplier", "offset"]);
    Ok(())
}
