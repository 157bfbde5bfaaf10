//! What must hold for the parts of a description, each by itself.

use std::collections::{HashMap, HashSet};

use nalgebra::Matrix3;

use super::Geometry;
use super::builder::{JointSpec, LinkSpec, ModelBuilder};
use super::sizes;
use crate::error::LoadError;
use crate::spatial::{Inertia, Transform};

/// How far `RᵀR` may be from the identity: well above rounding and six printed digits, well below a slip of the pen.
const ROTATION_TOLERANCE: f64 = 1e-5;

/// Checks names and numbers of all parts.
pub(super) fn check(builder: &ModelBuilder) -> Result<(), LoadError> {
    unique(builder, "link", builder.links.iter().map(|link| &link.name))?;
    unique(
        builder,
        "joint",
        builder.joints.iter().map(|joint| &joint.name),
    )?;
    let frames = builder
        .links
        .iter()
        .map(|link| &link.name)
        .chain(builder.frames.iter().map(|frame| &frame.name));
    unique(builder, "frame", frames)?;
    finite(
        builder,
        "robot",
        &builder.name,
        "gravity",
        builder.gravity.as_slice(),
    )?;
    for link in &builder.links {
        check_link(builder, link)?;
    }
    for joint in &builder.joints {
        check_joint(builder, joint)?;
    }
    check_mimics(builder)?;
    for frame in &builder.frames {
        check_pose(builder, "frame", &frame.name, &frame.placement)?;
    }
    Ok(())
}

fn unique<'a>(
    builder: &ModelBuilder,
    element: &str,
    names: impl Iterator<Item = &'a String>,
) -> Result<(), LoadError> {
    let mut seen = HashSet::new();
    for name in names {
        if !seen.insert(name) {
            return Err(LoadError::DuplicateName {
                file: builder.source.clone(),
                element: element.into(),
                name: name.clone(),
            });
        }
    }
    Ok(())
}

fn finite(
    builder: &ModelBuilder,
    element: &str,
    name: &str,
    quantity: &str,
    numbers: &[f64],
) -> Result<(), LoadError> {
    if numbers.iter().all(|x| x.is_finite()) {
        return Ok(());
    }
    let (file, element, name) = (builder.source.clone(), element.into(), name.into());
    Err(LoadError::NonFinite {
        file,
        element,
        name,
        quantity: quantity.into(),
    })
}

fn check_link(builder: &ModelBuilder, link: &LinkSpec) -> Result<(), LoadError> {
    let Inertia {
        mass,
        first_moment,
        rotational,
    } = &link.inertia;
    let of_link =
        |quantity: &str, numbers: &[f64]| finite(builder, "link", &link.name, quantity, numbers);
    of_link("mass", &[*mass])?;
    of_link("centre of mass", first_moment.as_slice())?;
    of_link("inertia", rotational.to_matrix().as_slice())?;
    if *mass < 0.0 {
        return Err(LoadError::NegativeMass {
            file: builder.source.clone(),
            link: link.name.clone(),
            mass: *mass,
        });
    }
    for visual in &link.visuals {
        check_pose(builder, "visual", &link.name, &visual.placement)?;
        check_size(builder, link, &visual.geometry, false)?;
    }
    for collision in &link.collisions {
        check_pose(builder, "collision", &link.name, &collision.placement)?;
        check_size(builder, link, &collision.geometry, true)?;
    }
    Ok(())
}

fn check_size(
    builder: &ModelBuilder,
    link: &LinkSpec,
    shape: &Geometry,
    touches: bool,
) -> Result<(), LoadError> {
    sizes::flaw(shape, touches).map_or(Ok(()), |(attribute, value, reason)| {
        malformed(builder, ["link", &link.name, attribute], value, reason)
    })
}

fn malformed(
    builder: &ModelBuilder,
    [element, name, attribute]: [&str; 3],
    value: f64,
    reason: &str,
) -> Result<(), LoadError> {
    Err(LoadError::Malformed {
        file: builder.source.clone(),
        element: element.into(),
        name: name.into(),
        attribute: attribute.into(),
        value: value.to_string(),
        reason: reason.into(),
    })
}

fn check_joint(builder: &ModelBuilder, joint: &JointSpec) -> Result<(), LoadError> {
    let of_joint =
        |quantity: &str, numbers: &[f64]| finite(builder, "joint", &joint.name, quantity, numbers);
    check_pose(builder, "joint", &joint.name, &joint.placement)?;
    of_joint("axis", joint.axis.as_slice())?;
    if joint.kind.has_axis() && joint.axis.amax() == 0.0 {
        return Err(LoadError::ZeroAxis {
            file: builder.source.clone(),
            joint: joint.name.clone(),
        });
    }
    of_joint("damping", &[joint.damping])?;
    of_joint("friction", &[joint.friction])?;
    of_joint("armature", &[joint.armature])?;
    of_joint("spring", &[joint.spring.stiffness, joint.spring.rest])?;
    for (quantity, x) in [
        ("damping", joint.damping),
        ("friction", joint.friction),
        ("armature", joint.armature),
        ("spring stiffness", joint.spring.stiffness),
    ] {
        if x < 0.0 {
            return malformed(builder, ["joint", &joint.name, quantity], x, "is negative");
        }
    }
    check_spring(builder, joint)?;
    let limits = &joint.limits;
    for (quantity, limit) in [
        ("lower limit", limits.lower),
        ("upper limit", limits.upper),
        ("velocity limit", limits.velocity),
        ("effort limit", limits.effort),
    ] {
        of_joint(quantity, &[limit.unwrap_or(0.0)])?;
    }
    if let Some(mimic) = &joint.mimic {
        of_joint("mimic", &[mimic.multiplier, mimic.offset])?;
    }
    check_limits(builder, joint)
}

/// A spring needs one coordinate to act along.
fn check_spring(builder: &ModelBuilder, joint: &JointSpec) -> Result<(), LoadError> {
    if joint.spring.stiffness == 0.0 || joint.kind.nv() <= 1 {
        return Ok(());
    }
    Err(LoadError::Malformed {
        file: builder.source.clone(),
        element: "joint".into(),
        name: joint.name.clone(),
        attribute: "spring stiffness".into(),
        value: joint.spring.stiffness.to_string(),
        reason: format!(
            "a {} joint has no single coordinate to act along",
            joint.kind
        ),
    })
}

fn check_limits(builder: &ModelBuilder, joint: &JointSpec) -> Result<(), LoadError> {
    let limits = &joint.limits;
    let fail = |reason: String| {
        Err(LoadError::InvalidLimits {
            file: builder.source.clone(),
            joint: joint.name.clone(),
            reason,
        })
    };
    if let (Some(lower), Some(upper)) = (limits.lower, limits.upper)
        && lower > upper
    {
        return fail(format!(
            "the lower limit {lower} is above the upper limit {upper}"
        ));
    }
    for (what, limit) in [("velocity", limits.velocity), ("effort", limits.effort)] {
        if let Some(limit) = limit
            && limit < 0.0
        {
            return fail(format!("the {what} limit {limit} is negative"));
        }
    }
    Ok(())
}

fn check_mimics(builder: &ModelBuilder) -> Result<(), LoadError> {
    let by_name: HashMap<&str, &JointSpec> = (builder.joints.iter())
        .map(|joint| (joint.name.as_str(), joint))
        .collect();
    for joint in &builder.joints {
        let Some(mimic) = &joint.mimic else { continue };
        let leader = by_name.get(mimic.leader.as_str()).copied();
        if let Some(reason) = mimic_flaw(joint, leader) {
            return Err(LoadError::InvalidMimic {
                file: builder.source.clone(),
                joint: joint.name.clone(),
                leader: mimic.leader.clone(),
                reason: reason.into(),
            });
        }
    }
    Ok(())
}

/// Why a joint cannot follow another, if it cannot.
fn mimic_flaw(joint: &JointSpec, leader: Option<&JointSpec>) -> Option<&'static str> {
    match leader {
        None => Some("there is no such joint"),
        Some(leader) if leader.name == joint.name => Some("a joint cannot follow itself"),
        Some(leader) if leader.kind.nv() > 1 || joint.kind.nv() > 1 => {
            Some("both need one degree of freedom at most")
        }
        Some(_) => None,
    }
}

fn check_pose(
    builder: &ModelBuilder,
    element: &str,
    name: &str,
    pose: &Transform<f64>,
) -> Result<(), LoadError> {
    finite(
        builder,
        element,
        name,
        "position",
        pose.translation.as_slice(),
    )?;
    finite(builder, element, name, "rotation", pose.rotation.as_slice())?;
    let defect = (pose.rotation.transpose() * pose.rotation - Matrix3::identity()).norm();
    if defect < ROTATION_TOLERANCE && pose.rotation.determinant() > 0.0 {
        return Ok(());
    }
    Err(LoadError::Malformed {
        file: builder.source.clone(),
        element: element.into(),
        name: name.into(),
        attribute: "rotation".into(),
        value: format!("{:?}", pose.rotation.as_slice()),
        reason: "is not a rotation matrix".into(),
    })
}
