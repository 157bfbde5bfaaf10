//! Triangle meshes as ground of arbitrary shape, which bodies touch from outside.

use crate::nested::IntoNested;
use crate::scalar::{MapEach, from_each};
use std::collections::HashMap;
use std::fmt;

use nalgebra::Vector3;

/// A triangle mesh, counter-clockwise as seen from outside. It need not be closed or convex.
///
/// Bodies touch each triangle as a separate convex shape. A contact normal that leans over an edge at which the mesh is flat or concave is dropped,
/// because the neighbouring triangle has the contact there. So bodies slide and roll over inner edges without bumps.
///
/// A body behind a triangle does not touch it: a body that is deeper in an open mesh than the middle of its shape falls through.
///
/// # Examples
/// ```
/// use dualbody::collision::Surface;
///
/// let step = Surface::grid([0.0, 0.0], [0.5, 1.0], [3, 2], &[0.0, 0.0, 0.2, 0.0, 0.0, 0.2])?;
/// assert_eq!((step.vertices().len(), step.triangles().len()), (6, 4));
/// # Ok::<(), dualbody::collision::SurfaceError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    vertices: Vec<Vector3<f64>>,
    triangles: Vec<[u32; 3]>,
    sides: Vec<TriangleSides>,
}

/// The directions from which a triangle of a mesh can be touched, in the frame of the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TriangleSides {
    /// Unit normal out of the mesh.
    normal: Vector3<f64>,
    /// Unit vectors across the sides, in the plane of the triangle and out of it.
    across: [Vector3<f64>; 3],
    /// The most that a normal of contact may lean across each side: as much as the normal of the triangle beyond, nothing where the mesh is hollow, and anything at
    /// its border.
    lean: [f64; 3],
}

/// The reason why a surface cannot be made, as a sentence.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum SurfaceError {
    /// There is no triangle with an area.
    Empty,
    /// A coordinate is infinite or NaN.
    NotFinite {
        /// Index of the vertex.
        vertex: usize,
    },
    /// A triangle refers to a vertex that does not exist.
    NoVertex {
        /// Index of the triangle.
        triangle: usize,
        /// Index of the vertex.
        vertex: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// A grid has too few points, or the number of heights differs from that of points.
    Grid {
        /// Points along x and y.
        points: [usize; 2],
        /// Number of heights.
        heights: usize,
    },
}

impl fmt::Display for SurfaceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => write!(f, "a surface has no triangle with an area"),
            Self::NotFinite { vertex } => write!(
                f,
                "vertex {vertex} of a surface has a coordinate that is not finite"
            ),
            Self::NoVertex {
                triangle,
                vertex,
                vertices,
            } => write!(
                f,
                "triangle {triangle} of a surface has the vertex {vertex}, of {vertices}"
            ),
            Self::Grid {
                points: [x, y],
                heights,
            } => write!(
                f,
                "a grid of {x} × {y} points with {heights} heights: expected at least 2 × 2, and a height for each"
            ),
        }
    }
}

impl std::error::Error for SurfaceError {}

/// Lean of a normal that counts as none: rounding of the normals of features that are nearest.
const UPRIGHT: f64 = 1e-6;

impl TriangleSides {
    /// Whether contact can have this normal, out of the mesh.
    pub(crate) fn admit(&self, normal: &Vector3<f64>) -> bool {
        let mut sides = self.across.iter().zip(self.lean);
        normal.dot(&self.normal) > 0.0
            && sides.all(|(across, lean)| normal.dot(across) <= lean + UPRIGHT)
    }
}

impl Surface {
    /// Makes a triangle mesh; drops triangles without area. Allocates.
    ///
    /// * `vertices` – in the frame of the mesh, m
    /// * `triangles` – indices of vertices, counter-clockwise as seen from outside
    ///
    /// # Errors
    /// If no triangle has an area, a coordinate is not finite, or an index is too large.
    pub fn new(
        vertices: Vec<Vector3<f64>>,
        triangles: Vec<[u32; 3]>,
    ) -> Result<Self, SurfaceError> {
        let is_finite = |v: &Vector3<f64>| v.iter().all(|x| x.is_finite());
        if let Some(vertex) = vertices.iter().position(|v| !is_finite(v)) {
            return Err(SurfaceError::NotFinite { vertex });
        }
        for (triangle, own) in triangles.iter().enumerate() {
            let missing = own.iter().find(|k| **k as usize >= vertices.len());
            if let Some(&vertex) = missing {
                return Err(SurfaceError::NoVertex {
                    triangle,
                    vertex,
                    vertices: vertices.len(),
                });
            }
        }
        let mut own = Self {
            vertices,
            triangles,
            sides: Vec::new(),
        };
        own.find_sides();
        if own.triangles.is_empty() {
            return Err(SurfaceError::Empty);
        }
        Ok(own)
    }

    /// Makes a grid of heights, touched from above: two triangles for each cell. Allocates.
    ///
    /// * `origin`, `spacing` – first point, and distance between points, along x and y, m
    /// * `points` – number of points along x and y, at least two
    /// * `heights` – m, row by row along x
    ///
    /// # Errors
    /// If there are fewer than two points along an axis, the number of heights is wrong, a value is not finite, or a spacing is zero.
    pub fn grid(
        origin: [f64; 2],
        spacing: [f64; 2],
        points: [usize; 2],
        heights: &[f64],
    ) -> Result<Self, SurfaceError> {
        let [x, y] = points;
        let fits = x.checked_mul(y) == Some(heights.len()) && heights.len() <= u32::MAX as usize;
        if !fits || x < 2 || y < 2 {
            let heights = heights.len();
            return Err(SurfaceError::Grid { points, heights });
        }
        let at = |k: usize| {
            let [i, j] = [k % x, k / x].map_each(|n| n as f64);
            let [x, y] = [origin[0] + i * spacing[0], origin[1] + j * spacing[1]];
            Vector3::new(x, y, heights[k])
        };
        let cells = (0..y - 1).nested(|j| (0..x - 1).map(move |i| (j * x + i) as u32));
        let row = x as u32;
        let triangles = cells.nested(|k| {
            let [right, above, both] = [k + 1, k + row, k + row + 1];
            [[k, right, both], [k, both, above]]
        });
        Self::new((0..heights.len()).map(at).collect(), triangles.collect())
    }

    /// The vertices, in the frame of the mesh, m.
    pub fn vertices(&self) -> &[Vector3<f64>] {
        &self.vertices
    }

    /// The triangles that have an area.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Each triangle with the directions from which it can be touched.
    pub(crate) fn each(&self) -> impl Iterator<Item = ([Vector3<f64>; 3], TriangleSides)> {
        let corners = self.triangles.iter().map(|own| self.corners(own));
        corners.zip(self.sides.iter().copied())
    }

    fn corners(&self, triangle: &[u32; 3]) -> [Vector3<f64>; 3] {
        triangle.map_each(|k| self.vertices[k as usize])
    }

    /// Leaves out what has no area, and finds what lies beyond the sides of the rest.
    fn find_sides(&mut self) {
        let normal = |own: &Self, triangle: &[u32; 3]| {
            let [a, b, c] = own.corners(triangle);
            (b - a).cross(&(c - a)).try_normalize(0.0)
        };
        let mut kept = std::mem::take(&mut self.triangles);
        kept.retain(|triangle| {
            normal(self, triangle).is_some_and(|n| n.iter().all(|x| x.is_finite()))
        });
        let normals: Vec<Vector3<f64>> = kept.iter().filter_map(|own| normal(self, own)).collect();
        let mut by_side = HashMap::with_capacity(3 * kept.len());
        for (triangle, n) in kept.iter().zip(&normals) {
            for k in 0..3 {
                by_side.insert([triangle[k], triangle[(k + 1) % 3]], *n);
            }
        }
        let sides = kept.iter().zip(&normals).map(|(triangle, normal)| {
            let corners = self.corners(triangle);
            let across: [Vector3<f64>; 3] = from_each(|k| {
                let along = corners[(k + 1) % 3] - corners[k];
                along.cross(normal).try_normalize(0.0).unwrap_or_default()
            });
            TriangleSides {
                normal: *normal,
                across,
                lean: from_each(|k| {
                    let beyond = by_side.get(&[triangle[(k + 1) % 3], triangle[k]]);
                    beyond.map_or(f64::INFINITY, |n| n.dot(&across[k]).max(0.0))
                }),
            }
        });
        self.sides = sides.collect();
        self.triangles = kept;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two triangles that meet along y, the second one turned up or down.
    fn fold(height: f64) -> Surface {
        let vertices = [
            [0.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [-1.0, 0.5, 0.0],
            [1.0, 0.5, height],
        ];
        let vertices = vertices.map(Vector3::from).to_vec();
        Surface::new(vertices, vec![[0, 1, 2], [1, 0, 3]]).expect("two triangles")
    }

    #[test]
    fn normals_may_lean_over_ridges_and_borders_and_nothing_else() {
        let up = |x: f64| Vector3::new(x, 0.0, 1.0).normalize();
        for (height, x, admitted) in [
            (0.0, 0.0, true),
            (0.0, 0.1, false),
            (0.0, -0.1, true),
            (-0.5, 0.1, true),
            (-0.5, 0.49, true),
            (-0.5, 0.51, false),
            (0.5, 0.1, false),
            (0.5, -0.1, true),
        ] {
            let surface = fold(height);
            assert_eq!(surface.sides[0].admit(&up(x)), admitted, "{height} {x}");
        }
        assert!(!fold(0.0).sides[0].admit(&-Vector3::z()));
    }

    #[test]
    fn broken_meshes_are_errors_and_slivers_are_left_out() {
        let vertices = vec![
            Vector3::zeros(),
            Vector3::x(),
            Vector3::y(),
            Vector3::x() * 2.0,
        ];
        let new = |triangles: Vec<[u32; 3]>| Surface::new(vertices.clone(), triangles);
        let mixed = new(vec![[0, 1, 3], [0, 1, 2], [1, 1, 2]]).expect("one triangle");
        assert_eq!(mixed.triangles(), [[0, 1, 2]]);
        assert_eq!(new(vec![[0, 1, 3]]), Err(SurfaceError::Empty));
        let missing = new(vec![[0, 1, 4]]).expect_err("no vertex 4").to_string();
        assert_eq!(missing, "triangle 0 of a surface has the vertex 4, of 4");
        let odd = vec![Vector3::x() * f64::NAN];
        let odd = Surface::new(odd, vec![[0, 0, 0]]);
        assert_eq!(odd, Err(SurfaceError::NotFinite { vertex: 0 }));
        for (points, heights) in [([2, 2], 3), ([1, 4], 4), ([usize::MAX, 2], 2)] {
            let grid = Surface::grid([0.0; 2], [1.0; 2], points, &vec![0.0; heights]);
            assert!(matches!(grid, Err(SurfaceError::Grid { .. })));
        }
    }
}
