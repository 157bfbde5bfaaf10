//! Checks of joints: axes, passive forces, limits, mimic joints.

use std::collections::HashMap;

use super::part::{Part, check_pose, malformed};
use crate::error::LoadError;
use crate::joint::JointKind;
use crate::model::axes::unit;
use crate::model::builder::{JointSpec, ModelBuilder};
use crate::model::{Limits, Spring};

pub(super) fn check_joint(builder: &ModelBuilder, joint: &JointSpec) -> Result<(), LoadError> {
    let part = Part::new(builder, "joint", &joint.name);
    check_pose(builder, "joint", &joint.name, &joint.placement)?;
    part.finite("axis", joint.axis.as_slice())?;
    if joint.kind.has_axis() && joint.axis.amax() == 0.0 {
        return Err(LoadError::ZeroAxis {
            at: builder.position("joint", &joint.name),
            joint: joint.name.clone(),
        });
    }
    if let JointKind::Screw(pitch) = joint.kind {
        part.bounded("pitch", &[pitch.metres_per_radian()])?;
    }
    check_second_axis(builder, joint)?;
    let own = Acting {
        damping: joint.damping,
        friction: joint.friction,
        armature: joint.armature,
        spring: &joint.spring,
    };
    check_acting(builder, joint, &own)?;
    check_spring(builder, joint)?;
    if let Some(mimic) = &joint.mimic {
        part.bounded("mimic", &[mimic.multiplier, mimic.offset])?;
    }
    check_limits(builder, joint, &joint.limits)
}

/// Passive forces along one axis of a joint, or along all.
struct Acting<'a> {
    damping: f64,
    friction: f64,
    armature: f64,
    spring: &'a Spring<f64>,
}

/// Checks the passive forces along one axis of a joint, or along all.
fn check_acting(
    builder: &ModelBuilder,
    joint: &JointSpec,
    acting: &Acting<'_>,
) -> Result<(), LoadError> {
    let Acting {
        damping,
        friction,
        armature,
        spring,
    } = *acting;
    let part = Part::new(builder, "joint", &joint.name);
    part.bounded("damping", &[damping])?;
    part.bounded("friction", &[friction])?;
    part.bounded("armature", &[armature])?;
    part.bounded("spring", &[spring.stiffness, spring.rest])?;
    for (quantity, x) in [
        ("damping", damping),
        ("friction", friction),
        ("armature", armature),
        ("spring stiffness", spring.stiffness),
    ] {
        if x < 0.0 {
            return malformed(builder, ["joint", &joint.name, quantity], x, "is negative");
        }
    }
    Ok(())
}

/// A universal joint has a second axis across the first, any other joint none.
fn check_second_axis(builder: &ModelBuilder, joint: &JointSpec) -> Result<(), LoadError> {
    /// Least sine of the angle between the axes, at which the inertia about one of the two is still more than rounding.
    const ACROSS: f64 = 1e-3;
    let of = |reason: &str| {
        let (axis, name) = (joint.second.as_ref(), joint.name.clone());
        let value = axis.map_or_else(String::new, |second| {
            format!("{:?}", second.axis.as_slice())
        });
        Err(LoadError::Malformed {
            at: builder.position("joint", &joint.name),
            element: "joint".into(),
            name,
            attribute: "second axis".into(),
            value,
            reason: reason.into(),
        })
    };
    let second = match (&joint.second, joint.kind) {
        (Some(second), JointKind::Universal) => second,
        (None, JointKind::Universal) => return of("is missing: a universal joint has two"),
        (None, _) => return Ok(()),
        (Some(_), kind) => return of(&format!("belongs to universal joints, not to a {kind} one")),
    };
    let part = Part::new(builder, "joint", &joint.name);
    part.finite("second axis", second.axis.as_slice())?;
    if second.axis.amax() == 0.0 {
        return Err(LoadError::ZeroAxis {
            at: builder.position("joint", &joint.name),
            joint: joint.name.clone(),
        });
    }
    if unit(&joint.axis).cross(&unit(&second.axis)).norm() < ACROSS {
        return of("is parallel to the first");
    }
    let own = Acting {
        damping: second.damping,
        friction: second.friction,
        armature: second.armature,
        spring: &second.spring,
    };
    check_acting(builder, joint, &own)?;
    check_limits(builder, joint, &second.limits)
}

/// A spring needs one coordinate to act along.
fn check_spring(builder: &ModelBuilder, joint: &JointSpec) -> Result<(), LoadError> {
    if joint.spring.stiffness == 0.0 || joint.kind.nv() <= 1 || joint.second.is_some() {
        return Ok(());
    }
    Err(LoadError::Malformed {
        at: builder.position("joint", &joint.name),
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

fn check_limits(
    builder: &ModelBuilder,
    joint: &JointSpec,
    limits: &Limits,
) -> Result<(), LoadError> {
    let part = Part::new(builder, "joint", &joint.name);
    for (quantity, limit) in [
        ("lower limit", limits.lower),
        ("upper limit", limits.upper),
        ("velocity limit", limits.velocity),
        ("effort limit", limits.effort),
    ] {
        part.finite(quantity, &[limit.unwrap_or(0.0)])?;
    }
    let fail = |reason: String| {
        Err(LoadError::InvalidLimits {
            at: builder.position("joint", &joint.name),
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

pub(super) fn check_mimics(builder: &ModelBuilder) -> Result<(), LoadError> {
    let by_name: HashMap<&str, &JointSpec> = (builder.joints.iter())
        .map(|joint| (joint.name.as_str(), joint))
        .collect();
    for joint in &builder.joints {
        let Some(mimic) = &joint.mimic else { continue };
        let leader = by_name.get(mimic.leader.as_str()).copied();
        if let Some(reason) = mimic_flaw(joint, leader) {
            return Err(LoadError::InvalidMimic {
                at: builder.position("joint", &joint.name),
                joint: joint.name.clone(),
                leader: mimic.leader.clone(),
                reason: reason.into(),
            });
        }
    }
    Ok(())
}

/// Reason why a joint cannot follow another, if it cannot.
fn mimic_flaw(joint: &JointSpec, leader: Option<&JointSpec>) -> Option<&'static str> {
    match leader {
        None => Some(
            "there is no such joint; the option independent_mimic_joints loads the robot, with mimic \
             joints that move independently",
        ),
        Some(leader) if leader.name == joint.name => Some("a joint cannot mimic itself"),
        Some(leader) if leader.kind.nv() > 1 || joint.kind.nv() > 1 => {
            Some("both need one degree of freedom at most")
        }
        Some(_) => None,
    }
}
