//! First pass over links: inertia, shapes, colours.

use super::document::{LinkEntry, Pass};
use super::schema;
use crate::error::LoadError;
use crate::io::context::{Node, child, children, is_native, tag};
use crate::io::numbers::{number, numbers, required};
use crate::io::schema::{Known, check};

/// Reads a link.
pub(super) fn read<'a>(
    pass: &mut Pass<'_, '_>,
    node: Node<'a>,
) -> Result<LinkEntry<'a>, LoadError> {
    check(pass.context, node, &schema::LINK)?;
    let name = pass.name(node)?;
    pass.out.start("link", &[("name", name)]);
    let inertial = child(node, "inertial");
    if let Some(inertial) = inertial {
        read_inertial(pass, inertial)?;
    }
    let entry = LinkEntry {
        inertial,
        visuals: read_shapes(pass, node, "visual", &schema::VISUAL)?,
        collisions: read_shapes(pass, node, "collision", &schema::COLLISION)?,
    };
    pass.out.end();
    Ok(entry)
}

fn read_inertial(pass: &mut Pass<'_, '_>, node: Node<'_>) -> Result<(), LoadError> {
    check(pass.context, node, &schema::INERTIAL)?;
    let (mass, inertia) = (pass.child(node, "mass")?, pass.child(node, "inertia")?);
    check(pass.context, mass, &schema::MASS)?;
    check(pass.context, inertia, &schema::INERTIA)?;
    required::<1>(pass.context, mass, "value")?;
    pass.out.start("inertial", &[]);
    pass.origin(node)?;
    pass.leaf("mass", mass, &["value"]);
    read_moments(pass, inertia)?;
    pass.out.end();
    Ok(())
}

/// Moments must be there; products that are not are zero.
fn read_moments(pass: &mut Pass<'_, '_>, inertia: Node<'_>) -> Result<(), LoadError> {
    for moment in ["ixx", "iyy", "izz"] {
        required::<1>(pass.context, inertia, moment)?;
    }
    for product in ["ixy", "ixz", "iyz"] {
        if number(pass.context, inertia, product)?.is_none() {
            pass.context
                .warn(inertia, format!("no {product}: taken as 0"));
        }
    }
    let entries = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"];
    let attributes = entries.map(|name| (name, inertia.attribute(name).unwrap_or("0")));
    pass.out.leaf("inertia", &attributes);
    Ok(())
}

/// Reads the visuals or collisions of a link; returns those that have a shape.
fn read_shapes<'a>(
    pass: &mut Pass<'_, '_>,
    link: Node<'a>,
    element: &'static str,
    known: &Known,
) -> Result<Vec<Node<'a>>, LoadError> {
    let mut read = Vec::new();
    for node in children(link, element) {
        check(pass.context, node, known)?;
        let Some((shape, known_shape)) = find_shape(pass, node)? else {
            pass.context.ignore(node, "has no shape that is known");
            continue;
        };
        let name = node.attribute("name").map(|name| ("name", name));
        pass.out.start(element, name.as_slice());
        pass.origin(node)?;
        read_geometry(pass, shape, known_shape)?;
        if let Some(material) = child(node, "material").filter(|_| element == "visual") {
            read_material(pass, material)?;
        }
        pass.out.end();
        read.push(node);
    }
    Ok(read)
}

/// The first shape of a visual or collision; reports the others.
fn find_shape<'a>(
    pass: &mut Pass<'_, '_>,
    node: Node<'a>,
) -> Result<Option<(Node<'a>, &'static Known)>, LoadError> {
    let Some(geometry) = child(node, "geometry") else {
        return Ok(None);
    };
    check(pass.context, geometry, &schema::GEOMETRY)?;
    let mut found = None;
    for shape in geometry.children().filter(|shape| is_native(*shape)) {
        let known = schema::SHAPES.iter().find(|(name, _)| *name == tag(shape));
        match known {
            Some((_, known)) if found.is_none() => found = Some((shape, known)),
            Some(_) => pass.context.ignore(shape, "only the first shape is read"),
            None => {}
        }
    }
    Ok(found)
}

fn read_geometry(pass: &mut Pass<'_, '_>, shape: Node<'_>, known: &Known) -> Result<(), LoadError> {
    check(pass.context, shape, known)?;
    let lengths: &[f64] = match tag(shape) {
        "box" => &required::<3>(pass.context, shape, "size")?,
        "sphere" => &required::<1>(pass.context, shape, "radius")?,
        "mesh" => {
            pass.attribute(shape, "filename")?;
            numbers::<3>(pass.context, shape, "scale")?;
            &[]
        }
        _ => &[
            required::<1>(pass.context, shape, "radius")?[0],
            required::<1>(pass.context, shape, "length")?[0],
        ],
    };
    if lengths.iter().any(|&length| length <= 0.0) {
        pass.context.warn(shape, "a length is not positive");
    }
    pass.out.start("geometry", &[]);
    let attributes = ["size", "radius", "length", "filename", "scale"];
    pass.leaf(tag(shape), shape, &attributes);
    pass.out.end();
    Ok(())
}

/// Reads a material. A colour that cannot be understood costs the colour, not the robot.
pub(super) fn read_material(pass: &mut Pass<'_, '_>, node: Node<'_>) -> Result<(), LoadError> {
    check(pass.context, node, &schema::MATERIAL)?;
    let name = node.attribute("name").unwrap_or_default();
    pass.out.start("material", &[("name", name)]);
    if let Some(color) = child(node, "color") {
        check(pass.context, color, &schema::COLOR)?;
        match required::<4>(pass.context, color, "rgba") {
            Ok(_) => pass.leaf("color", color, &["rgba"]),
            Err(error) => pass.context.warn(color, format!("no colour: {error}")),
        }
    }
    pass.out.end();
    Ok(())
}
