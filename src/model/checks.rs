//! Checks of the parts of a description, each by itself.

use std::collections::{HashMap, HashSet};

use nalgebra::Matrix3;

use super::Geometry;
use super::axes::unit;
use super::builder::{JointSpec, LinkSpec, ModelBuilder};
use super::{Limits, Model, Spring, sizes};
use crate::error::{LARGEST_NUMBER, LoadError};
use crate::joint::JointKind;
use crate::spatial::{Inertia, Transform};

/// Largest deviation of `RᵀR` from the identity: well above rounding and six printed digits, well below a slip of the pen.
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
    let gravity = builder.gravity.as_slice();
    Part::new(builder, "robot", &builder.name).bounded("gravity", gravity)?;
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
        if name.is_empty() {
            return Err(LoadError::Missing {
                file: builder.source.clone(),
                element: element.into(),
                name: name.clone(),
                missing: "name".into(),
            });
        }
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

/// A part of a description, as messages name it.
#[derive(Clone, Copy)]
struct Part<'a> {
    builder: &'a ModelBuilder,
    element: &'a str,
    name: &'a str,
}

impl<'a> Part<'a> {
    fn new(builder: &'a ModelBuilder, element: &'a str, name: &'a str) -> Self {
        Self {
            builder,
            element,
            name,
        }
    }

    fn finite(self, quantity: &str, numbers: &[f64]) -> Result<(), LoadError> {
        if numbers.iter().all(|x| x.is_finite()) {
            return Ok(());
        }
        Err(LoadError::NonFinite {
            file: self.builder.source.clone(),
            element: self.element.into(),
            name: self.name.into(),
            quantity: quantity.into(),
        })
    }

    /// Finite numbers of which products of three, which the dynamics take, are finite.
    fn bounded(self, quantity: &str, numbers: &[f64]) -> Result<(), LoadError> {
        self.finite(quantity, numbers)?;
        let Some(&value) = numbers.iter().find(|x| x.abs() > LARGEST_NUMBER) else {
            return Ok(());
        };
        Err(LoadError::TooLarge {
            file: self.builder.source.clone(),
            element: self.element.into(),
            name: self.name.into(),
            quantity: quantity.into(),
            value,
        })
    }
}

/// Checks numbers that are sums over the parts: inertias and poses over fixed joints, what acts along coordinates of leaders.
pub(super) fn check_sums(builder: &ModelBuilder, model: &Model<f64>) -> Result<(), LoadError> {
    for frame in &model.frames {
        let position = frame.placement.translation.as_slice();
        Part::new(builder, "frame", &frame.name).bounded("position on its body", position)?;
    }
    for link in model.links() {
        let frame = &model.frames[link.frame.0];
        if let Some(body) = frame.body {
            check_inertia(
                builder,
                "body of link",
                &frame.name,
                &model.body(body).inertia,
            )?;
        }
    }
    for joint in model.joint_parts() {
        let body = model.body(joint.body);
        let part = Part::new(builder, "joint", &model.joint_of(joint.id).name);
        let position = body.placement.translation.as_slice();
        part.bounded("position on its body", position)?;
        if let Some(coupling) = &body.coupling {
            part.bounded(
                "ratio or offset to its leader",
                &[coupling.ratio, coupling.offset],
            )?;
        }
        for k in body.v..body.v + body.joint.nv() {
            let spring = &model.springs[k];
            part.bounded("damping with its followers", &[model.damping[k]])?;
            part.bounded("armature with its followers", &[model.armature[k]])?;
            part.bounded(
                "spring with its followers",
                &[spring.stiffness, spring.rest],
            )?;
        }
    }
    Ok(())
}

fn check_inertia(
    builder: &ModelBuilder,
    element: &str,
    name: &str,
    inertia: &Inertia<f64>,
) -> Result<(), LoadError> {
    let (mass, rotational) = ([inertia.mass], inertia.rotational.to_matrix());
    let quantities = [
        ("mass", mass.as_slice()),
        ("centre of mass", inertia.first_moment.as_slice()),
        ("inertia", rotational.as_slice()),
    ];
    let part = Part::new(builder, element, name);
    for (quantity, numbers) in quantities {
        part.finite(quantity, numbers)?;
    }
    for (quantity, numbers) in quantities {
        part.bounded(quantity, numbers)?;
    }
    Ok(())
}

fn check_link(builder: &ModelBuilder, link: &LinkSpec) -> Result<(), LoadError> {
    check_inertia(builder, "link", &link.name, &link.inertia)?;
    if link.inertia.mass < 0.0 {
        return Err(LoadError::NegativeMass {
            file: builder.source.clone(),
            link: link.name.clone(),
            mass: link.inertia.mass,
        });
    }
    if link.inertia.mass > 0.0 {
        // The centre of mass is a moment by a mass.
        let part = Part::new(builder, "link", &link.name);
        part.bounded("reciprocal of the mass", &[link.inertia.mass.recip()])?;
    }
    let visuals = (link.visuals.iter()).map(|shape| ("visual", &shape.placement, &shape.geometry));
    let collisions = link.collisions.iter();
    let collisions = collisions.map(|shape| ("collision", &shape.placement, &shape.geometry));
    for (element, placement, geometry) in visuals.chain(collisions) {
        check_pose(builder, element, &link.name, placement)?;
        Part::new(builder, element, &link.name).bounded("size", &lengths(geometry))?;
    }
    for visual in &link.visuals {
        check_size(builder, link, &visual.geometry, false)?;
    }
    for collision in &link.collisions {
        check_size(builder, link, &collision.geometry, true)?;
    }
    Ok(())
}

/// Numbers that the size of a shape is made of: lengths, or the scale of a mesh.
fn lengths(geometry: &Geometry) -> Vec<f64> {
    match *geometry {
        Geometry::Box { size: lengths } | Geometry::Mesh { scale: lengths, .. } => lengths.to_vec(),
        Geometry::Sphere { radius } => vec![radius],
        Geometry::Cylinder { radius, length } | Geometry::Capsule { radius, length } => {
            vec![radius, length]
        }
    }
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
    let part = Part::new(builder, "joint", &joint.name);
    check_pose(builder, "joint", &joint.name, &joint.placement)?;
    part.finite("axis", joint.axis.as_slice())?;
    if joint.kind.has_axis() && joint.axis.amax() == 0.0 {
        return Err(LoadError::ZeroAxis {
            file: builder.source.clone(),
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
            file: builder.source.clone(),
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
            file: builder.source.clone(),
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

/// Reason why a joint cannot follow another, if it cannot.
fn mimic_flaw(joint: &JointSpec, leader: Option<&JointSpec>) -> Option<&'static str> {
    match leader {
        None => Some(
            "there is no such joint (ModelOptions::with_independent_mimic_joints loads the robot all the same: \
             joints that mimic others then move independently)",
        ),
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
    let position = pose.translation.as_slice();
    let part = Part::new(builder, element, name);
    part.bounded("position", position)?;
    part.finite("rotation", pose.rotation.as_slice())?;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Visual;

    /// A rod on the world, and a plate that is fixed to it.
    fn parts() -> ModelBuilder {
        let mut builder = ModelBuilder::new("rod");
        builder.add_link(LinkSpec::new("world"));
        builder.add_link(LinkSpec::new("rod").with_mass(1.0, [0.0; 3], [1.0; 3]));
        builder.add_link(LinkSpec::new("plate").with_mass(1.0, [0.0; 3], [1.0; 3]));
        builder.add_joint(JointSpec::new(
            "pivot",
            JointKind::Continuous,
            "world",
            "rod",
        ));
        builder.add_joint(JointSpec::new("weld", JointKind::Fixed, "rod", "plate"));
        builder
    }

    fn error(change: impl FnOnce(&mut ModelBuilder)) -> String {
        let mut builder = parts();
        change(&mut builder);
        match builder.build() {
            Ok(_) => panic!("no error"),
            Err(error) => error.to_string(),
        }
    }

    #[test]
    fn numbers_whose_products_overflow_are_errors_that_name_them() {
        for (error, parts) in [
            (
                error(|b| b.gravity.z = -1e300),
                ["<robot> \"rod\"", "gravity -1e300"],
            ),
            (
                error(|b| b.joints[1].placement.translation.x = 1e308),
                ["\"weld\"", "position 1e308"],
            ),
            (
                error(|b| b.joints[0].damping = 1e200),
                ["\"pivot\"", "damping 1e200"],
            ),
            (
                error(|b| b.joints[0].spring.stiffness = 1e308),
                ["\"pivot\"", "spring 1e308"],
            ),
            (
                error(|b| b.links[1].inertia.mass = 1e200),
                ["\"rod\"", "mass 1e200"],
            ),
            (
                error(|b| b.links[1].inertia.mass = 1e-200),
                ["\"rod\"", "reciprocal of the mass 1e200"],
            ),
            (
                error(|b| b.links[1].inertia.mass = 5e-324),
                ["\"rod\"", "reciprocal of the mass is not finite"],
            ),
            (
                error(|b| {
                    b.links[1].visuals.push(Visual {
                        name: None,
                        placement: Transform::identity(),
                        geometry: Geometry::Sphere { radius: 1e300 },
                        color: None,
                    });
                }),
                ["<visual> \"rod\"", "size 1e300"],
            ),
        ] {
            assert!(parts.iter().all(|part| error.contains(part)), "{error}");
        }
        // Allowed each, but not in the sum: m p² of a plate far away.
        let far = error(|b| b.joints[1].placement.translation.x = 1e60);
        assert!(
            far.contains("<body of link> \"rod\"") && far.contains("e119 is out of range"),
            "{far}"
        );
        let mut large = parts();
        large.joints[1].placement.translation.x = 1e40;
        assert!(large.build().is_ok());
    }

    #[test]
    fn empty_names_are_errors() {
        for (error, element) in [
            (error(|b| b.links[2].name.clear()), "<link>"),
            (error(|b| b.joints[1].name.clear()), "<joint>"),
            (
                error(|b| {
                    b.add_frame("", "rod", Transform::identity());
                }),
                "<frame>",
            ),
        ] {
            assert!(
                error.contains(element) && error.contains("has no name"),
                "{error}"
            );
        }
    }

    #[test]
    fn unknown_leader_is_an_error_that_tells_the_option() {
        let error = error(|b| {
            b.joints[0].mimic = Some(crate::model::Mimic {
                leader: "none".into(),
                multiplier: 1.0,
                offset: 0.0,
            });
        });
        assert!(error.contains("with_independent_mimic_joints"), "{error}");
    }
}
