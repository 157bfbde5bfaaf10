//! Checks of links: inertia and shapes.

use super::part::{Part, check_pose, malformed};
use crate::error::LoadError;
use crate::model::builder::{LinkSpec, ModelBuilder};
use crate::model::{Geometry, sizes};
use crate::spatial::Inertia;

pub(super) fn check_inertia(
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

pub(super) fn check_link(builder: &ModelBuilder, link: &LinkSpec) -> Result<(), LoadError> {
    check_inertia(builder, "link", &link.name, &link.inertia)?;
    if link.inertia.mass < 0.0 {
        return Err(LoadError::NegativeMass {
            at: builder.position("link", &link.name),
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
        let color = visual.color.unwrap_or_default();
        Part::new(builder, "visual", &link.name).finite("colour", &color)?;
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
        Geometry::Box { size: lengths }
        | Geometry::Ellipsoid { size: lengths }
        | Geometry::Mesh { scale: lengths, .. } => lengths.to_vec(),
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
