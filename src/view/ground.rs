//! The ground in pictures.

use crate::nested::IntoNested;
use serde::{Deserialize, Serialize};

use super::mesh::Mesh;
use super::meshes::Meshes;
use super::shape::{Shape, pose};
use crate::contact::Terrain;
use crate::scalar::MapEach;
use crate::spatial::Transform;

/// Samples along each side of a ground that is not level.
const SAMPLES: usize = 64;

/// The colour of a ground that is not level.
const COLOR: [f64; 4] = [0.66, 0.68, 0.62, 1.0];

/// Heights on a regular grid, drawn with linear interpolation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Heights {
    /// Position of the first sample, x and y, m.
    pub origin: [f64; 2],
    /// Distance of grid points along x and y, m; positive.
    pub spacing: [f64; 2],
    /// Number of grid points along x and y, at least two.
    pub size: [usize; 2],
    /// The heights, x running fastest, m.
    pub heights: Vec<f64>,
}

impl Heights {
    /// Samples a ground on a rectangle from one corner to the other.
    pub(super) fn of(terrain: &Terrain, [from, to]: [[f64; 2]; 2]) -> Self {
        let n = if matches!(terrain, Terrain::Plane(_)) {
            2
        } else {
            SAMPLES
        };
        let spacing = [0, 1].map_each(|axis| (to[axis] - from[axis]) / (n - 1) as f64);
        let at = |axis: usize, k: usize| from[axis] + spacing[axis] * k as f64;
        let height = |k: usize| terrain.surface(&at(0, k % n), &at(1, k / n)).height;
        Self {
            origin: from,
            spacing,
            size: [n, n],
            heights: (0..n * n).map(height).collect(),
        }
    }

    /// Flaw of the heights; `None` if they have none.
    pub(super) fn flaw(&self) -> Option<&'static str> {
        let [nx, ny] = self.size;
        if nx < 2 || ny < 2 || nx.checked_mul(ny) != Some(self.heights.len()) {
            return Some(
                "a ground needs a height for each node and at least two nodes along each side",
            );
        }
        let is_positive = self.spacing.iter().all(|&x| x > 0.0);
        (!is_positive).then_some("the distance of heights is not positive")
    }

    pub(super) fn numbers(&self) -> Vec<f64> {
        [&self.origin[..], &self.spacing, &self.heights].concat()
    }

    /// The height where all are one.
    pub(super) fn level(&self) -> Option<f64> {
        let first = self.heights[0];
        self.heights.iter().all(|&z| z == first).then_some(first)
    }

    /// A surface of triangles.
    pub(super) fn shape(&self, placement: &Transform<f64>, meshes: &mut Meshes) -> Shape {
        let (middle, piece) = meshes.surface(self.mesh());
        Shape {
            body: None,
            pose: pose(&(*placement * Transform::from_translation(middle))),
            color: Some(COLOR),
            piece,
        }
    }

    fn mesh(&self) -> Mesh {
        let [nx, ny] = self.size;
        let place = |k: usize| {
            let at = [k % nx, k / nx];
            let [x, y] =
                [0, 1].map_each(|axis| self.origin[axis] + self.spacing[axis] * at[axis] as f64);
            [x, y, self.heights[k]].map_each(|x| x as f32)
        };
        // Two triangles a cell, seen from above.
        let cells = (0..ny - 1).nested(|j| (0..nx - 1).map(move |i| j * nx + i));
        let triangles = cells.nested(|a| [[a, a + 1, a + nx], [a + nx, a + 1, a + nx + 1]]);
        let index = |k: usize| u32::try_from(k).unwrap_or(u32::MAX);
        let triangles = triangles.map(|triangle| triangle.map(index));
        Mesh::new((0..nx * ny).map(place).collect(), triangles.collect(), None)
    }
}
