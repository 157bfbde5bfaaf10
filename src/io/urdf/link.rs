//! Reads links: inertia, shapes, colours.

use super::part::{LinkElements, ShapeElements};
use super::reader::Reader;
use super::schema;
use crate::error::LoadError;
use crate::io::context::{Node, child, children};
use crate::io::schema::{Known, check};
use crate::io::shapes;
use crate::io::values::{Attributes, INERTIA_ENTRIES, Values};

/// Reads a link.
pub(super) fn read<'a>(
    reader: &mut Reader<'_, '_>,
    node: Node<'a>,
) -> Result<(urdf_rs::Link, LinkElements<'a>), LoadError> {
    check(reader.context, node, &schema::LINK)?;
    let name = reader.attribute(node, "name")?;
    let inertial = child(node, "inertial");
    let inertial = inertial.map(|inertial| read_inertial(reader, inertial));
    let inertial = inertial.transpose()?.unwrap_or_default();
    let (visual, visuals) = read_shapes(reader, node, "visual", &schema::VISUAL)?;
    let (collision, collisions) = read_shapes(reader, node, "collision", &schema::COLLISION)?;
    let link = urdf_rs::Link {
        name,
        inertial,
        visual,
        collision: collision.into_iter().map(without_material).collect(),
    };
    let elements = LinkElements {
        link: node,
        visuals,
        collisions,
    };
    Ok((link, elements))
}

fn read_inertial(
    reader: &mut Reader<'_, '_>,
    node: Node<'_>,
) -> Result<urdf_rs::Inertial, LoadError> {
    check(reader.context, node, &schema::INERTIAL)?;
    let (mass, inertia) = (reader.child(node, "mass")?, reader.child(node, "inertia")?);
    check(reader.context, mass, &schema::MASS)?;
    check(reader.context, inertia, &schema::INERTIA)?;
    let [value] = Attributes::required(reader.context, mass, "value")?;
    Ok(urdf_rs::Inertial {
        mass: urdf_rs::Mass { value },
        origin: reader.origin(node)?,
        inertia: read_moments(reader, inertia)?,
    })
}

/// Moments must be there; products that are not are zero.
fn read_moments(
    reader: &mut Reader<'_, '_>,
    node: Node<'_>,
) -> Result<urdf_rs::Inertia, LoadError> {
    let mut entries = [0.0; 6];
    // The moments first: which of two errors is told.
    for k in [0, 3, 5] {
        [entries[k]] = Attributes::required(reader.context, node, INERTIA_ENTRIES[k])?;
    }
    for k in [1, 2, 4] {
        let name = INERTIA_ENTRIES[k];
        match Attributes::number(reader.context, node, name)? {
            Some(product) => entries[k] = product,
            None => reader.context.warn(node, format!("no {name}: taken as 0")),
        }
    }
    let [ixx, ixy, ixz, iyy, iyz, izz] = entries;
    Ok(urdf_rs::Inertia {
        ixx,
        ixy,
        ixz,
        iyy,
        iyz,
        izz,
    })
}

/// Reads the visuals or collisions of a link that have a shape.
fn read_shapes<'a>(
    reader: &mut Reader<'_, '_>,
    link: Node<'a>,
    element: &'static str,
    known: &Known,
) -> Result<(Vec<urdf_rs::Visual>, Vec<ShapeElements<'a>>), LoadError> {
    let (mut read, mut elements) = (Vec::new(), Vec::new());
    for node in children(link, element) {
        check(reader.context, node, known)?;
        let Some(shape) = shapes::find(reader.context, node, &schema::SHAPES)? else {
            continue;
        };
        let origin = reader.origin(node)?;
        let geometry = shapes::read::<Attributes>(reader.context, &shape, &schema::SHAPES)?;
        let material = child(node, "material").filter(|_| element == "visual");
        let material = material.map(|material| read_material(reader, material));
        read.push(urdf_rs::Visual {
            name: node.attribute("name").map(Into::into),
            origin,
            geometry,
            material: material.transpose()?,
        });
        elements.push(ShapeElements { node, shape });
    }
    Ok((read, elements))
}

fn without_material(visual: urdf_rs::Visual) -> urdf_rs::Collision {
    urdf_rs::Collision {
        name: visual.name,
        origin: visual.origin,
        geometry: visual.geometry,
    }
}

/// Reads a material. A colour that cannot be understood costs the colour, not the robot.
pub(super) fn read_material(
    reader: &mut Reader<'_, '_>,
    node: Node<'_>,
) -> Result<urdf_rs::Material, LoadError> {
    check(reader.context, node, &schema::MATERIAL)?;
    let mut material = urdf_rs::Material {
        name: node.attribute("name").unwrap_or_default().into(),
        ..Default::default()
    };
    if let Some(color) = child(node, "color") {
        check(reader.context, color, &schema::COLOR)?;
        match Attributes::required(reader.context, color, "rgba") {
            Ok(rgba) => {
                let rgba = urdf_rs::Vec4(rgba);
                material.color = Some(urdf_rs::Color { rgba });
            }
            Err(error) => reader.context.warn(color, format!("no colour: {error}")),
        }
    }
    Ok(material)
}
