//! Surfaces of parameters, and checks of these.

use crate::scalar::MapEach;

/// The most vertices that the meshes of a model get in this way: parameters of few digits make many.
pub(super) const MOST_VERTICES: usize = 200_000;

/// Vertices, and the corners of triangles; without them the surface is that of the convex hull.
pub(super) struct Surface {
    pub(super) vertices: Vec<[f32; 3]>,
    pub(super) triangles: Option<Vec<[u32; 3]>>,
}

/// A surface, or the reason why its parameters are out of range.
pub(super) type Made = Result<Surface, String>;

/// A surface of points, in single precision as meshes have it there and here.
pub(super) fn surface(points: &[[f64; 3]], triangles: Option<Vec<[u32; 3]>>) -> Surface {
    Surface {
        vertices: points.iter().map(|p| p.map_each(|x| x as f32)).collect(),
        triangles,
    }
}

/// A whole number from its least to its largest value; fractions are cut off, as there.
pub(super) fn whole(name: &str, x: f64, least: usize, largest: usize) -> Result<usize, String> {
    let x = x.trunc();
    match (least as f64..=largest as f64).contains(&x) {
        true => Ok(x as usize),
        false => Err(format!("{name} is not from {least} to {largest}")),
    }
}

/// Checks a number that must be in a range.
pub(super) fn within(name: &str, x: f64, is_in: bool, range: &str) -> Result<f64, String> {
    match is_in {
        true => Ok(x),
        false => Err(format!("{name} {x} is not {range}")),
    }
}

/// Checks the number of vertices before they are made.
pub(super) fn fits(vertices: usize, left: usize) -> Result<(), String> {
    match vertices <= left {
        true => Ok(()),
        false => Err(format!(
            "such meshes get more than {MOST_VERTICES} vertices"
        )),
    }
}
