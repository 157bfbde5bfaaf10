//! Triangles of the shapes.

use crate::nested::IntoNested;
use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;

use crate::scalar::MapEach;
use crate::view::mesh::Mesh;
use crate::view::meshes::{Piece, Solid};

/// Corner of a triangle: its place in the piece, m, and the outward normal there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub(super) position: Vector3<f64>,
    pub(super) normal: Vector3<f64>,
}

/// Pieces around the axis of a round shape, and from pole to pole of a ball.
const AROUND: usize = 32;
const ALONG: usize = 16;

/// Corners of the triangles of a piece, three after three.
pub(super) fn triangles(piece: &Piece, meshes: &[Mesh]) -> Vec<Corner> {
    let size = Vector3::from(piece.size);
    match (piece.shape, piece.mesh) {
        (Solid::Mesh, Some(i)) => mesh(&meshes[i], &size),
        (Solid::Box | Solid::Mesh, _) => cuboid(&size),
        (Solid::Sphere, _) => ellipsoid(&size),
        (Solid::Capsule, _) => ball(size.x, size.z),
        (Solid::Cylinder, _) => cylinder(size.x, size.z),
    }
}

/// An arrow from the origin along z; a tip that is longer than half of it would be all that one sees.
pub(super) fn arrow(length: f64, thickness: f64) -> Vec<Corner> {
    let stem = length - (4.0 * thickness).min(0.5 * length);
    let mut out = rod(thickness / 2.0, 0.0, stem);
    for j in 0..AROUND {
        let edge = |j: usize| Corner {
            position: around(j) * (1.4 * thickness) + Vector3::z() * stem,
            normal: around(j),
        };
        let (tip, middle) = (Vector3::z() * length, Vector3::z() * stem);
        out.extend([
            edge(j),
            edge(j + 1),
            Corner {
                position: tip,
                normal: around(j),
            },
        ]);
        let back = |position: Vector3<f64>| Corner {
            position,
            normal: -Vector3::z(),
        };
        out.extend([
            back(edge(j).position),
            back(edge(j + 1).position),
            back(middle),
        ]);
    }
    out
}

/// A rod along z.
pub(super) fn rod(radius: f64, from: f64, to: f64) -> Vec<Corner> {
    let mut out = cylinder(radius, to - from);
    out.iter_mut()
        .for_each(|corner| corner.position.z += (from + to) / 2.0);
    out
}

fn mesh(mesh: &Mesh, size: &Vector3<f64>) -> Vec<Corner> {
    let vertex = |i: u32| Vector3::from(mesh.positions[i as usize]).component_mul(size);
    let triangles = mesh.triangles.iter().nested(|corners| {
        let at = corners.map_each(vertex);
        let normal = (at[1] - at[0]).cross(&(at[2] - at[0])).try_normalize(0.0);
        let normal = normal.unwrap_or_else(Vector3::z);
        at.map_each(|position| Corner { position, normal })
    });
    triangles.collect()
}

fn cuboid(size: &Vector3<f64>) -> Vec<Corner> {
    let mut out = Vec::with_capacity(36);
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let at = |u: f64, v: f64| {
                let mut unit = Vector3::zeros();
                unit[axis] = side;
                let normal = unit;
                unit[(axis + 1) % 3] = u;
                unit[(axis + 2) % 3] = v;
                Corner {
                    position: unit.component_mul(size) * 0.5,
                    normal,
                }
            };
            add_quad(
                &mut out,
                [at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)],
            );
        }
    }
    out
}

/// A ball whose halves are this far apart along z: a capsule.
fn ellipsoid(semi_axes: &Vector3<f64>) -> Vec<Corner> {
    let mut out = ball(1.0, 0.0);
    for corner in &mut out {
        corner.position.component_mul_assign(semi_axes);
        corner.normal = corner.normal.component_div(semi_axes).normalize();
    }
    out
}

fn ball(radius: f64, length: f64) -> Vec<Corner> {
    let at = |i: usize, j: usize, shift: f64| {
        let (down, around) = (PI * i as f64 / ALONG as f64, TAU * j as f64 / AROUND as f64);
        let normal = Vector3::new(
            down.sin() * around.cos(),
            down.sin() * around.sin(),
            down.cos(),
        );
        Corner {
            position: normal * radius + Vector3::z() * shift,
            normal,
        }
    };
    let shift = |i: usize| {
        if i <= ALONG / 2 {
            length / 2.0
        } else {
            -length / 2.0
        }
    };
    let mut out = Vec::new();
    let mut add_ring = |i: usize, upper: f64, k: usize, lower: f64| {
        for j in 0..AROUND {
            add_quad(
                &mut out,
                [
                    at(i, j, upper),
                    at(k, j, lower),
                    at(k, j + 1, lower),
                    at(i, j + 1, upper),
                ],
            );
        }
    };
    for i in 0..ALONG {
        let half = if i < ALONG / 2 {
            shift(0)
        } else {
            shift(ALONG)
        };
        add_ring(i, half, i + 1, half);
    }
    if length > 0.0 {
        add_ring(ALONG / 2, shift(0), ALONG / 2, shift(ALONG));
    }
    out
}

fn cylinder(radius: f64, length: f64) -> Vec<Corner> {
    let mut out = Vec::new();
    for j in 0..AROUND {
        let corner = |j: usize, side: f64| {
            let normal = around(j);
            Corner {
                position: normal * radius + Vector3::z() * (side * length / 2.0),
                normal,
            }
        };
        add_quad(
            &mut out,
            [
                corner(j, 1.0),
                corner(j, -1.0),
                corner(j + 1, -1.0),
                corner(j + 1, 1.0),
            ],
        );
        for side in [-1.0, 1.0] {
            let normal = Vector3::z() * side;
            let end = |position: Vector3<f64>| Corner {
                position: position + normal * (length / 2.0),
                normal,
            };
            out.extend([
                end(Vector3::zeros()),
                end(around(j) * radius),
                end(around(j + 1) * radius),
            ]);
        }
    }
    out
}

/// Direction from the axis of a round shape.
fn around(j: usize) -> Vector3<f64> {
    let angle = TAU * j as f64 / AROUND as f64;
    Vector3::new(angle.cos(), angle.sin(), 0.0)
}

fn add_quad(out: &mut Vec<Corner>, [a, b, c, d]: [Corner; 4]) {
    out.extend([a, b, c, a, c, d]);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Volume within a closed surface whose triangles are turned outward, by the divergence theorem; their winding may be either.
    fn volume(corners: &[Corner]) -> f64 {
        let of = |triangle: &[Corner]| {
            let [a, b, c] = [0, 1, 2].map(|k| triangle[k].position);
            let outward = (b - a).cross(&(c - a)).dot(&triangle[0].normal);
            a.dot(&b.cross(&c)) / 6.0 * outward.signum()
        };
        corners
            .chunks(3)
            .filter(|t| {
                (t[1].position - t[0].position)
                    .cross(&(t[2].position - t[0].position))
                    .norm()
                    > 1e-12
            })
            .map(of)
            .sum()
    }

    #[test]
    fn volumes_of_surfaces_equal_those_of_the_solids() {
        let piece = |shape, size| Piece {
            shape,
            size,
            mesh: None,
        };
        let ball = 4.0 / 3.0 * PI * 0.125;
        for (solid, size, expected, tolerance) in [
            (Solid::Box, [1.0, 2.0, 3.0], 6.0, 1e-12),
            (Solid::Sphere, [0.5; 3], ball, 2e-2),
            (Solid::Cylinder, [0.5, 0.5, 2.0], PI * 0.5, 1e-2),
            (Solid::Capsule, [0.5, 0.5, 2.0], ball + PI * 0.5, 2e-2),
        ] {
            let found = volume(&triangles(&piece(solid, size), &[]));
            assert!(
                (found / expected - 1.0).abs() < tolerance,
                "{solid:?}: {found} against {expected}"
            );
        }
    }
}
