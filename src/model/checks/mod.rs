//! Checks of the individual parts of a description.

mod joints;
mod links;
mod part;

use std::collections::HashSet;

use self::joints::{check_joint, check_mimics};
use self::links::{check_inertia, check_link};
use self::part::Part;
pub(super) use self::part::check_pose;
use super::Model;
use super::builder::ModelBuilder;
use crate::error::LoadError;

/// Checks names and parameters of all parts.
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
                at: builder.position(element, name),
                element: element.into(),
                name: name.clone(),
                missing: "name".into(),
            });
        }
        if !seen.insert(name) {
            return Err(LoadError::DuplicateName {
                at: builder.position(element, name),
                element: element.into(),
                name: name.clone(),
            });
        }
    }
    Ok(())
}

/// Checks sums over parts: inertias and poses over fixed joints, damping, armature and springs of leaders.
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
            part.bounded("damping with its mimic joints", &[model.damping[k]])?;
            part.bounded("armature with its mimic joints", &[model.armature[k]])?;
            part.bounded(
                "spring with its mimic joints",
                &[spring.stiffness, spring.rest],
            )?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint::JointKind;
    use crate::model::builder::{JointSpec, LinkSpec};
    use crate::model::{Geometry, Visual};
    use crate::spatial::Transform;

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
        assert!(
            error.contains("the option independent_mimic_joints"),
            "{error}"
        );
    }
}
