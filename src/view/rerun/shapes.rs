//! Shapes as Rerun knows them.

use nalgebra::Vector3;
use re_types::AsComponents;
use re_types::archetypes::{Boxes3D, Capsules3D, Cylinders3D, Ellipsoids3D, Mesh3D};
use re_types::components::FillMode;
use re_types::datatypes::Rgba32;

use crate::view::mesh::Mesh;
use crate::view::meshes::Solid;
use crate::view::shape::Shape;

/// Colour of shapes without one, that of the first robot of an HTML viewer.
const PLAIN: [f64; 4] = [0.55, 0.62, 0.72, 1.0];

/// A shape, centred at its own origin.
pub(super) fn archetype(shape: &Shape, meshes: &[Mesh]) -> Box<dyn AsComponents> {
    let color = color(shape.color.unwrap_or(PLAIN));
    let size = shape.piece.size.map(|x| x as f32);
    let [radius, _, length] = size;
    let solid = FillMode::Solid;
    match (shape.piece.shape, shape.piece.mesh) {
        (Solid::Mesh, Some(i)) => Box::new(mesh(&meshes[i], size, color)),
        (Solid::Box | Solid::Mesh, _) => Box::new(
            Boxes3D::from_half_sizes([size.map(|x| 0.5 * x)])
                .with_colors([color])
                .with_fill_mode(solid),
        ),
        (Solid::Sphere, _) => Box::new(
            Ellipsoids3D::from_half_sizes([size])
                .with_colors([color])
                .with_fill_mode(solid),
        ),
        (Solid::Cylinder, _) => Box::new(
            Cylinders3D::from_lengths_and_radii([length], [radius])
                .with_colors([color])
                .with_fill_mode(solid),
        ),
        // Rerun's capsules begin at their origin.
        (Solid::Capsule, _) => Box::new(
            Capsules3D::from_lengths_and_radii([length], [radius])
                .with_translations([[0.0, 0.0, -0.5 * length]])
                .with_colors([color])
                .with_fill_mode(solid),
        ),
    }
}

fn color(rgba: [f64; 4]) -> Rgba32 {
    let [r, g, b, a] = rgba.map(|x| (x.clamp(0.0, 1.0) * f64::from(u8::MAX)).round() as u8);
    Rgba32::from_unmultiplied_rgba(r, g, b, a)
}

/// Triangles with normals of their own: without any the viewer draws a mesh without light.
fn mesh(mesh: &Mesh, size: [f32; 3], color: Rgba32) -> Mesh3D {
    let size = Vector3::from(size);
    let vertex = |i: u32| {
        let unit = Vector3::from(mesh.positions[i as usize]).map(|x| x as f32);
        unit.component_mul(&size)
    };
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    for corners in &mesh.triangles {
        let [a, b, c] = corners.map(vertex);
        let normal = (b - a).cross(&(c - a)).try_normalize(0.0);
        positions.extend([a, b, c].map(<[f32; 3]>::from));
        normals.extend([<[f32; 3]>::from(normal.unwrap_or_else(Vector3::z)); 3]);
    }
    let corners = (0..positions.len() as u32).step_by(3);
    Mesh3D::new(positions)
        .with_vertex_normals(normals)
        .with_triangle_indices(corners.map(|i| [i, i + 1, i + 2]))
        .with_albedo_factor(color)
}
