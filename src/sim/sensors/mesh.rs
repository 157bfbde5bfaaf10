//! Triangle meshes that range finders see.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use nalgebra::Vector3;

use super::ray::LocalRay;
use crate::collision::{Bounds, BroadPhase, HalfLine, Surface};
use crate::memory;
use crate::model::{Geometry, UpAxis};
use crate::scalar::Scalar;
use crate::spatial::linear::{dot, lift_vector};

/// Bytes of a triangle with its boxes and those above it.
const TRIANGLE_BYTES: usize = 3 * size_of::<u32>() + 6 * size_of::<Bounds>();

/// The triangles of a mesh in a tree of boxes, in the frame of the file.
#[derive(Debug)]
pub(crate) struct MeshTree {
    surface: Surface,
    tree: BroadPhase,
}

impl MeshTree {
    /// Makes the tree of a mesh. Allocates; O(n log n).
    ///
    /// # Errors
    /// If the mesh has no triangle with an area, or the tree needs more memory than the limit: the end of a sentence "the mesh …".
    pub(crate) fn new(
        vertices: Vec<Vector3<f64>>,
        triangles: Vec<[u32; 3]>,
    ) -> Result<Arc<Self>, String> {
        let n = triangles.len();
        let what = format_args!("boxes of the {n} triangles of a mesh");
        let checked = memory::check(what, n.saturating_mul(TRIANGLE_BYTES));
        checked.map_err(|error| format!("is too large: {error}"))?;
        let surface = Surface::new(vertices, triangles);
        let surface = surface.map_err(|error| format!("cannot be seen: {error}"))?;
        let bounds = (0..surface.triangles().len()).map(|k| around(&corners(&surface, k)));
        let tree = BroadPhase::of_fixed(&bounds.collect::<Vec<_>>());
        Ok(Arc::new(Self { surface, tree }))
    }
}

#[cfg(not(feature = "formats"))]
impl MeshTree {
    /// Reads no files.
    fn of_file(_: &Geometry) -> Result<Arc<Self>, String> {
        Err("is not read".into())
    }
}

/// Result of reading a mesh, or the reason why it is not seen, as an end of the sentence "the mesh …".
type FoundMesh = Result<Arc<MeshTree>, String>;

/// Trees of mesh files, each file read once.
#[derive(Debug, Default)]
pub(super) struct MeshFiles {
    found: HashMap<(PathBuf, UpAxis), FoundMesh>,
}

impl MeshFiles {
    /// The tree of a mesh, without its scale.
    pub(super) fn tree(&mut self, mesh: &Geometry) -> FoundMesh {
        let Geometry::Mesh {
            path: Some(path),
            up_axis,
            ..
        } = mesh
        else {
            return Err("is not found".into());
        };
        let found = self.found.entry((path.clone(), *up_axis));
        found.or_insert_with(|| MeshTree::of_file(mesh)).clone()
    }
}

fn corners(surface: &Surface, triangle: usize) -> [Vector3<f64>; 3] {
    surface.triangles()[triangle].map(|k| surface.vertices()[k as usize])
}

fn around([a, b, c]: &[Vector3<f64>; 3]) -> Bounds {
    Bounds {
        low: a.inf(b).inf(c),
        high: a.sup(b).sup(c),
    }
}

impl<T: Scalar> LocalRay<T> {
    /// Takes the distance to a mesh, where that is nearer.
    ///
    /// * `factors` – of the mesh along its axes, not zero. The ray is stretched the other way, which keeps its distances.
    pub(super) fn hit_mesh(&mut self, mesh: &MeshTree, factors: [f64; 3]) {
        let stretched = |x: &Vector3<T>| Vector3::from_fn(|k, _| x[k] / factors[k]);
        let own = Self {
            origin: stretched(&self.origin),
            direction: stretched(&self.direction),
            nearest: self.nearest,
        };
        self.nearest = own.with_triangles(&mesh.tree, |k| corners(&mesh.surface, k));
    }

    /// The nearest distance, triangles in a tree of their boxes taken into account: which of them is met is decided on plain values, lane by lane.
    pub(super) fn with_triangles(
        &self,
        tree: &BroadPhase,
        triangle: impl Fn(usize) -> [Vector3<f64>; 3],
    ) -> T {
        assert!(
            T::HAS_VALUES,
            "range finders that see meshes cannot be recorded: which triangle a ray meets is decided on values"
        );
        let mut nearest = self.nearest;
        for lane in 0..T::LANES {
            let plain = |x: &Vector3<T>| x.map(|x| x.value(lane));
            let line = HalfLine {
                origin: plain(&self.origin),
                direction: plain(&self.direction),
            };
            let end = self.nearest.value(lane);
            if let Some(corners) = tree.first_met(&line, end, &triangle) {
                let is_lane = T::from_values(|k| f64::from(u8::from(k == lane)));
                nearest = T::zero().select_lt(is_lane, self.to_triangle(&corners), nearest);
            }
        }
        nearest
    }

    /// The distance to the plane of a triangle:  n · (a − o) / n · d.
    fn to_triangle(&self, [a, b, c]: &[Vector3<f64>; 3]) -> T {
        let normal = lift_vector::<f64, T>(&(b - a).cross(&(c - a)));
        let corner = lift_vector::<f64, T>(a);
        dot(&normal, &(corner - self.origin)) / dot(&normal, &self.direction)
    }
}
