//! The search for a convex hull.

use std::panic::catch_unwind;

use glam::Vec3A;
use quickhull::ConvexTriangleMesh;

/// The convex hull of some points as the library finds it; it panics where it cannot.
pub(super) fn convex(points: &[Vec3A]) -> Result<ConvexTriangleMesh, String> {
    match catch_unwind(|| ConvexTriangleMesh::try_from_points(points, None)) {
        Ok(found) => found.map_err(|error| format!("has no convex hull: {error}")),
        Err(_) => Err("has no convex hull that can be found".into()),
    }
}
