//! Distances of rays to triangles: which is met is decided on plain values, the distance is over the scalar.

use nalgebra::Vector3;

use super::mesh::MeshTree;
use super::ray::LocalRay;
use crate::collision::{BroadPhase, HalfLine};
use crate::scalar::Scalar;
use crate::spatial::linear::{dot, lift_vector};

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
        self.nearest = own.with_triangles(mesh.boxes(), |k| mesh.corners(k));
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
