//! Invalid sizes of shapes.

use super::Geometry;
use crate::scalar::MapEach;

/// The invalid size of a shape, if there is one: its name, its value and the reason. Visuals may have zero
/// size.
pub(super) fn flaw(shape: &Geometry, touches: bool) -> Option<(&'static str, f64, &'static str)> {
    let sizes = match *shape {
        Geometry::Box { size } => size.map_each(|x| ("size", x)).to_vec(),
        // Each of them is a diameter.
        Geometry::Ellipsoid { size } => size.map_each(|x| ("size", x)).to_vec(),
        Geometry::Mesh { scale, .. } => scale.map_each(|x| ("scale", x)).to_vec(),
        Geometry::Cylinder { radius, length } | Geometry::Capsule { radius, length } => {
            vec![("radius", radius), ("length", length)]
        }
        Geometry::Sphere { radius } => vec![("radius", radius)],
    };
    let is_round = matches!(shape, Geometry::Ellipsoid { .. });
    let may_be_mirrored = matches!(shape, Geometry::Mesh { .. });
    sizes.into_iter().find_map(|(name, x)| {
        let reason = match x {
            _ if !x.is_finite() => "is not finite",
            _ if x < 0.0 && !may_be_mirrored => "is negative",
            _ if x == 0.0 && touches && (name == "radius" || is_round) => "is not positive",
            _ if x == 0.0 && name == "scale" => {
                "makes the mesh flat, and lengths along the axis are lost"
            }
            _ => return None,
        };
        Some((name, x, reason))
    })
}
