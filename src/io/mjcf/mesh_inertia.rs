//! Inertia of what a mesh encloses.

use std::ops::AddAssign;

use crate::nested::IntoNested;
use nalgebra::{Matrix3, Matrix4, Vector3};

use crate::io::mesh::Mesh;
use crate::scalar::MapEach;
use crate::spatial::{Inertia, Transform};

/// Rule by which the volumes between the middle of a mesh and its triangles are added up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Volumes {
    /// By their size: of open surfaces too, and too much where a triangle faces the middle.
    Absolute,
    /// With their signs: right for closed surfaces.
    Signed,
    /// With their signs, of the convex hull.
    Hull,
    /// None: the mass is on the surface, and densities are per area.
    Shell,
}

/// The inertia of a mesh, scaled along the axes, at density 1, in the frame of its file.
///
/// # Errors
/// If the mesh has no volume, or a shell no area.
///
/// # References
/// The attribute `inertia` of meshes in the XML reference of `MuJoCo`.
pub(super) fn of(mesh: Mesh, scale: [f64; 3], volumes: Volumes) -> Result<Inertia<f64>, String> {
    let mesh = match volumes {
        Volumes::Hull => mesh.hull()?,
        _ => mesh,
    };
    let triangles = triangles(&mesh, scale);
    let middle = middle(&triangles);
    if volumes == Volumes::Shell {
        return shell(&triangles, middle);
    }
    let mut sum = about(&triangles, middle, volumes);
    let com = middle + sum.first_moment / sum.mass;
    if volumes == Volumes::Absolute {
        // Mass and moments are those of the volumes between the centre of mass and the triangles: larger ones, if the surface is not convex.
        let rest = about(&triangles, com, volumes);
        sum = Inertia::from_com(rest.mass, &(com - middle), &rest.rotational);
    }
    if !(sum.mass > 0.0 && sum.to_matrix().iter().all(|x| x.is_finite())) {
        return Err("has no volume".into());
    }
    Ok(Transform::from_translation(middle).inertia(&sum))
}

/// The sum of the volumes between a point and the triangles, at density 1, about that point.
fn about(triangles: &[[Vector3<f64>; 3]], point: Vector3<f64>, volumes: Volumes) -> Inertia<f64> {
    let sum = triangles.iter().fold(Inertia::zero(), |sum, triangle| {
        let corners = std::iter::once(triangle.map_each(|p| p - point));
        let own = Inertia::solid_polyhedron(1.0, corners);
        match volumes {
            Volumes::Absolute => sum + own.scaled(own.mass.signum()),
            Volumes::Signed | Volumes::Hull | Volumes::Shell => sum + own,
        }
    });
    // Triangles that all face inwards.
    sum.scaled(sum.mass.signum())
}

/// The inertia of triangles with mass 1 per area.
fn shell(triangles: &[[Vector3<f64>; 3]], middle: Vector3<f64>) -> Result<Inertia<f64>, String> {
    let mut sum = Matrix4::zeros();
    for triangle in triangles {
        let [a, b, c] = triangle.map_each(|p| p - middle);
        let mass = 0.5 * (b - a).cross(&(c - a)).norm();
        let all = a + b + c;
        let squares = [a, b, c, all].map_each(|p| p * p.transpose());
        let moments = squares.iter().sum::<Matrix3<f64>>() * (mass / 12.0);
        let first = all * (mass / 3.0);
        sum.fixed_view_mut::<3, 3>(0, 0).add_assign(&moments);
        sum.fixed_view_mut::<3, 1>(0, 3).add_assign(&first);
        sum[(3, 3)] += mass;
    }
    if !(sum[(3, 3)] > 0.0 && sum.iter().all(|x| x.is_finite())) {
        return Err("has no area".into());
    }
    let own = Inertia::from_pseudo_inertia(&sum);
    Ok(Transform::from_translation(middle).inertia(&own))
}

fn triangles(mesh: &Mesh, scale: [f64; 3]) -> Vec<[Vector3<f64>; 3]> {
    let parts = mesh.parts.iter().nested(|part| {
        let corner = move |i: u32| {
            let p = part.vertices[i as usize];
            Vector3::from_fn(|k, _| f64::from(p[k]) * scale[k])
        };
        part.triangles
            .iter()
            .map(move |triangle| triangle.map(corner))
    });
    parts.collect()
}

/// The mean of all triangles, weighted by their area.
fn middle(triangles: &[[Vector3<f64>; 3]]) -> Vector3<f64> {
    let (mut area, mut moment) = (0.0, Vector3::zeros());
    for [a, b, c] in triangles {
        let own = (b - a).cross(&(c - a)).norm();
        area += own;
        moment += (a + b + c) * (own / 3.0);
    }
    match area {
        0.0 => Vector3::zeros(),
        _ => moment / area,
    }
}
