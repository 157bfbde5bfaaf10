//! Shapes of links: formats write them in the same way, with the same sizes, as attributes or as child elements.

use super::context::{Context, Node, child, is_native, tag};
use super::mesh_path::MeshFinder;
use super::place::Place;
use super::schema::{Known, check};
use super::values::Values;
use crate::error::LoadError;
use crate::model::Geometry;
use crate::scalar::MapEach;

/// The elements of shapes in a format.
#[derive(Debug)]
pub(super) struct Shapes {
    /// Content of `<geometry>`: the names of the shapes.
    pub(super) names: Known,
    /// Shapes, each with what it holds.
    pub(super) shapes: &'static [(&'static str, Known)],
    /// Name of the value with the reference to a mesh.
    pub(super) file: &'static str,
}

/// A shape of a visual or collision with the element that gives its size.
#[derive(Debug)]
pub(super) struct Shape<'a> {
    pub(super) node: Node<'a>,
    known: &'static Known,
}

/// The first shape of a visual or collision; reports the others, and an element without any.
pub(super) fn find<'a>(
    context: &mut Context<'_>,
    node: Node<'a>,
    format: &'static Shapes,
) -> Result<Option<Shape<'a>>, LoadError> {
    let mut found = None;
    if let Some(geometry) = child(node, "geometry") {
        check(context, geometry, &format.names)?;
        for shape in geometry.children().filter(|shape| is_native(*shape)) {
            let known = format.shapes.iter().find(|(name, _)| *name == tag(shape));
            match known {
                Some((_, known)) if found.is_none() => found = Some(Shape { node: shape, known }),
                Some(_) => context.ignore(shape, "only the first shape is read"),
                None => {}
            }
        }
    }
    if found.is_none() {
        context.ignore(node, "has no shape that is known");
    }
    Ok(found)
}

/// Reads the size of a shape, or the reference to its mesh.
pub(super) fn read<V: Values>(
    context: &mut Context<'_>,
    shape: &Shape<'_>,
    format: &Shapes,
    meshes: &mut MeshFinder,
) -> Result<Geometry, LoadError> {
    let Shape { node, known } = *shape;
    check(context, node, known)?;
    match tag(node) {
        "mesh" => {
            let uri = V::required_text(context, node, format.file)?;
            let scale = V::numbers(context, node, "scale")?;
            return Ok(meshes.geometry(&uri, scale));
        }
        "box" => {
            let size = V::required(context, node, "size")?;
            return Ok(Geometry::Box { size });
        }
        "ellipsoid" => {
            let radii: [f64; 3] = V::required(context, node, "radii")?;
            let size = radii.map_each(|radius| 2.0 * radius);
            return Ok(Geometry::Ellipsoid { size });
        }
        _ => {}
    }
    let [radius] = V::required(context, node, "radius")?;
    if tag(node) == "sphere" {
        return Ok(Geometry::Sphere { radius });
    }
    let [length] = V::required(context, node, "length")?;
    Ok(match tag(node) {
        "capsule" => Geometry::Capsule { radius, length },
        _ => Geometry::Cylinder { radius, length },
    })
}

/// Remarks on a size that may not be what its author wanted, and on a mesh that is not found.
///
/// * `size`, `mesh` – places of these remarks
pub(super) fn check_shape(
    context: &mut Context<'_>,
    geometry: &Geometry,
    meshes: &MeshFinder,
    [size, mesh]: [Place<'_>; 2],
) {
    let least = match *geometry {
        Geometry::Box { size: [x, y, z] } | Geometry::Ellipsoid { size: [x, y, z] } => {
            x.min(y).min(z)
        }
        Geometry::Sphere { radius } => radius,
        Geometry::Cylinder { radius, length } | Geometry::Capsule { radius, length } => {
            radius.min(length)
        }
        Geometry::Mesh { .. } => f64::INFINITY,
    };
    if least <= 0.0 {
        context.warn(size, "a length is not positive");
    }
    if let Some(reason) = meshes.flaw(geometry) {
        context.warn(mesh, reason);
    }
}
