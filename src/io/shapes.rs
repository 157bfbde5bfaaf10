//! Shapes of links: formats write them in the same way, with the same sizes, as attributes or as child elements.

use super::context::{Context, Node, child, is_native, tag};
use super::schema::{Known, check};
use super::values::Values;
use crate::error::LoadError;
use crate::model::Geometry;

/// The elements of shapes in a format.
#[derive(Debug)]
pub(super) struct Shapes {
    /// Shapes, each with what it holds.
    pub(super) shapes: [(&'static str, Known); 5],
    /// Name of the value with the reference to a mesh.
    pub(super) file: &'static str,
}

/// Content of `<geometry>`.
const GEOMETRY: Known = Known {
    attributes: &[],
    once: &[],
    repeated: &["box", "cylinder", "capsule", "sphere", "mesh"],
};

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
        check(context, geometry, &GEOMETRY)?;
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
) -> Result<urdf_rs::Geometry, LoadError> {
    let Shape { node, known } = *shape;
    check(context, node, known)?;
    match tag(node) {
        "mesh" => {
            let filename = V::required_text(context, node, format.file)?.into_owned();
            let scale = V::numbers(context, node, "scale")?.map(urdf_rs::Vec3);
            return Ok(urdf_rs::Geometry::Mesh { filename, scale });
        }
        "box" => {
            let size = urdf_rs::Vec3(V::required(context, node, "size")?);
            return Ok(urdf_rs::Geometry::Box { size });
        }
        _ => {}
    }
    let [radius] = V::required(context, node, "radius")?;
    if tag(node) == "sphere" {
        return Ok(urdf_rs::Geometry::Sphere { radius });
    }
    let [length] = V::required(context, node, "length")?;
    Ok(match tag(node) {
        "capsule" => urdf_rs::Geometry::Capsule { radius, length },
        _ => urdf_rs::Geometry::Cylinder { radius, length },
    })
}

/// Remark on the size of a shape that may not be what its author wanted.
pub(super) fn flaw(geometry: &Geometry) -> Option<&'static str> {
    let least = match *geometry {
        Geometry::Box { size: [x, y, z] } => x.min(y).min(z),
        Geometry::Sphere { radius } => radius,
        Geometry::Cylinder { radius, length } | Geometry::Capsule { radius, length } => {
            radius.min(length)
        }
        Geometry::Mesh { .. } => return None,
    };
    (least <= 0.0).then_some("a length is not positive")
}
