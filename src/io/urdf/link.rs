//! Reads links: inertia, shapes, colours.

use super::parts::{LinkPart, Material};
use super::reader::Reader;
use super::{inertia_of, schema};
use crate::error::LoadError;
use crate::io::context::{Node, child, children};
use crate::io::schema::{Known, check};
use crate::io::shapes;
use crate::io::values::{Attributes, INERTIA_ENTRIES, Values};
use crate::model::Collision;
use crate::spatial::Inertia;

/// Reads a link.
pub(super) fn read<'a>(
    reader: &mut Reader<'_, '_>,
    node: Node<'a>,
) -> Result<LinkPart<'a>, LoadError> {
    check(reader.context, node, &schema::LINK)?;
    let name = reader.attribute(node, "name")?;
    let (place, inertia) = match child(node, "inertial") {
        Some(inertial) => (inertial, read_inertial(reader, inertial)?),
        None => (node, Inertia::zero()),
    };
    let mut link = LinkPart::new(reader.context, place.into(), name, inertia);
    link.place = node.into();
    for visual in children(node, "visual") {
        if let Some(shape) = read_shape(reader, visual, &schema::VISUAL)? {
            let material = child(visual, "material");
            let material = material.map(|material| read_material(reader, material));
            link.visuals.push((shape, material.transpose()?));
        }
    }
    for collision in children(node, "collision") {
        let shape = read_shape(reader, collision, &schema::COLLISION)?;
        link.collisions.extend(shape);
    }
    Ok(link)
}

fn read_inertial(reader: &mut Reader<'_, '_>, node: Node<'_>) -> Result<Inertia<f64>, LoadError> {
    check(reader.context, node, &schema::INERTIAL)?;
    let (mass, inertia) = (reader.child(node, "mass")?, reader.child(node, "inertia")?);
    check(reader.context, mass, &schema::MASS)?;
    check(reader.context, inertia, &schema::INERTIA)?;
    let [mass] = Attributes::required(reader.context, mass, "value")?;
    let X_LC = reader.origin(node)?;
    Ok(inertia_of(mass, read_moments(reader, inertia)?, &X_LC))
}

/// Moments must be there; products that are not are zero.
fn read_moments(reader: &mut Reader<'_, '_>, node: Node<'_>) -> Result<[f64; 6], LoadError> {
    let mut entries = [0.0; 6];
    // The moments first: this decides which of two errors is reported.
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
    Ok(entries)
}

/// Reads a visual or collision, if it has a shape.
fn read_shape(
    reader: &mut Reader<'_, '_>,
    node: Node<'_>,
    known: &Known,
) -> Result<Option<Collision>, LoadError> {
    check(reader.context, node, known)?;
    let Some(shape) = shapes::find(reader.context, node, &schema::SHAPES)? else {
        return Ok(None);
    };
    let placement = reader.origin(node)?;
    let (context, meshes) = (&mut *reader.context, &mut *reader.meshes);
    let geometry = shapes::read::<Attributes>(context, &shape, &schema::SHAPES, meshes)?;
    let places = [shape.node.into(), node.into()];
    shapes::check_shape(context, &geometry, meshes, places);
    Ok(Some(Collision {
        name: node.attribute("name").map(Into::into),
        placement,
        geometry,
    }))
}

/// Reads a material. A colour that cannot be understood costs the colour, not the robot.
pub(super) fn read_material<'a>(
    reader: &mut Reader<'_, '_>,
    node: Node<'a>,
) -> Result<Material<'a>, LoadError> {
    check(reader.context, node, &schema::MATERIAL)?;
    let mut color = None;
    if let Some(node) = child(node, "color") {
        check(reader.context, node, &schema::COLOR)?;
        match Attributes::required(reader.context, node, "rgba") {
            Ok(rgba) => color = Some(rgba),
            Err(error) => reader.context.warn(node, format!("no colour: {error}")),
        }
    }
    Ok(Material {
        place: node.into(),
        name: node.attribute("name").unwrap_or_default(),
        color,
        is_reference: node.first_element_child().is_none(),
    })
}
