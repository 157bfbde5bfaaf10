//! Contact points of the collision shapes of links.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::f64::consts::TAU;
use std::fmt;

use nalgebra::{Matrix3, Vector3};

use super::laws::ContactLaw;
use super::point::{ContactPoint, Feature};
use crate::error::OutOfMemory;
use crate::memory;
use crate::model::{Collision, Geometry, Model, short_reference};
use crate::nested::IntoNested;
use crate::scalar::{MapEach, from_each};
use crate::spatial::Transform;
use crate::spatial::geometry::thinned;

/// Points on each rim of a cylinder: enough for a stable stance.
const RIM_POINTS: usize = 3;
/// Bytes of a point with its law.
const POINT_BYTES: usize = size_of::<ContactPoint>() + size_of::<ContactLaw>();

/// Options for converting shapes to contact points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ContactOptions {
    /// Maximum number of points of a mesh; 64 by default, and no points for zero. From a hull with more vertices, a subset is chosen that best
    /// preserves its extent in all directions: for a ball, the error is 7 % of the radius with 64 points and less than 2 % with 256. More points cost
    /// time in every step.
    pub mesh_points: usize,
}

impl Default for ContactOptions {
    fn default() -> Self {
        Self { mesh_points: 64 }
    }
}

/// A collision shape without points.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShapeWithoutPoints {
    /// The link.
    pub link: String,
    /// Description of the shape, with the reason why it has no points.
    pub reason: String,
}

impl fmt::Display for ShapeWithoutPoints {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "link \"{}\": {}", self.link, self.reason)
    }
}

/// Source of mesh vertices for contact: the vertices of convex hulls.
pub trait MeshHulls {
    /// Vertices of the convex hull of a mesh in its own frame, without its scale, m; or why there are none, as an end of the sentence "the mesh …".
    ///
    /// * `mesh` – a [`Geometry::Mesh`]; asked for once for each collision shape that is one
    ///
    /// # Errors
    /// If there are no vertices, with the reason.
    fn vertices(&mut self, mesh: &Geometry) -> Result<&[[f32; 3]], String>;

    /// Remarks on how meshes were read, a sentence each.
    fn remarks(&self) -> Vec<String> {
        Vec::new()
    }
}

/// Source without meshes: only the other shapes of the robot have contact points.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoMeshes;

impl MeshHulls for NoMeshes {
    fn vertices(&mut self, _: &Geometry) -> Result<&[[f32; 3]], String> {
        Err("is not read".to_owned())
    }
}

/// Centres and features in the frame of a shape, or why there are none.
type Features = Result<Vec<(Vector3<f64>, Feature)>, String>;

/// Contact points of the collision shapes of a robot, and the shapes that have none.
#[derive(Debug, Default)]
pub(super) struct ShapePoints {
    pub(super) points: Vec<ContactPoint>,
    /// The shapes without points.
    pub(super) shapes_without_points: Vec<ShapeWithoutPoints>,
}

/// The points of all collision shapes of a robot, except shapes fixed to the world.
///
/// # Errors
/// If they would need more memory than the [limit](crate::memory): a mesh of many vertices may be that of many shapes.
pub(super) fn points_of(
    model: &Model,
    options: &ContactOptions,
    meshes: &mut dyn MeshHulls,
) -> Result<ShapePoints, OutOfMemory> {
    let (mut points, mut shapes_without_points) = (Vec::new(), Vec::new());
    for link in model.links() {
        let frame = &model.frames()[link.frame.0];
        let Some(body) = frame.body else { continue };
        for shape in &link.collisions {
            let found = features(shape, meshes, options);
            if let Err(reason) = &found {
                shapes_without_points.push(ShapeWithoutPoints {
                    link: frame.name.clone(),
                    reason: reason.clone(),
                });
            }
            let X_BS = frame.placement * shape.placement;
            let found = found.unwrap_or_default();
            check_memory(points.len() + found.len())?;
            let placed = found.into_iter();
            points.extend(placed.map(|(center, feature)| ContactPoint {
                link: link.frame,
                body,
                center: X_BS.point(&center),
                feature: turned(&X_BS, feature),
            }));
        }
    }
    Ok(ShapePoints {
        points,
        shapes_without_points,
    })
}

/// Refuses more points than there is memory for.
fn check_memory(points: usize) -> Result<(), OutOfMemory> {
    let bytes = points.saturating_mul(POINT_BYTES);
    memory::check(format_args!("{points} contact points"), bytes)
}

fn turned(X_BS: &Transform<f64>, feature: Feature) -> Feature {
    match feature {
        Feature::Rim {
            axis,
            radius,
            angle,
        } => Feature::Rim {
            axis: X_BS.rotation * axis,
            radius,
            angle,
        },
        Feature::Ellipsoid { semi_axes } => Feature::Ellipsoid {
            semi_axes: X_BS.rotation * semi_axes,
        },
        other => other,
    }
}

fn features(shape: &Collision, meshes: &mut dyn MeshHulls, options: &ContactOptions) -> Features {
    let on_axis = |z: f64| Vector3::new(0.0, 0.0, z);
    Ok(match &shape.geometry {
        Geometry::Sphere { radius } => {
            vec![(Vector3::zeros(), Feature::Sphere { radius: *radius })]
        }
        Geometry::Capsule { radius, length } => [-0.5, 0.5]
            .map_each(|end| (on_axis(end * length), Feature::Sphere { radius: *radius }))
            .to_vec(),
        Geometry::Ellipsoid { size } => {
            let half = Vector3::from(size.map_each(|x| 0.5 * x));
            let semi_axes = Matrix3::from_diagonal(&half);
            vec![(Vector3::zeros(), Feature::Ellipsoid { semi_axes })]
        }
        Geometry::Box { size } => corners(size).map_each(|c| (c, Feature::Corner)).to_vec(),
        Geometry::Cylinder { radius, length } => {
            let ends = [-0.5, 0.5].into_iter();
            let rims = ends.nested(|end| (0..RIM_POINTS).map(move |k| (end, k)));
            let rim = |(end, k): (f64, usize)| {
                let feature = Feature::Rim {
                    axis: Vector3::z(),
                    radius: *radius,
                    angle: TAU * k as f64 / RIM_POINTS as f64,
                };
                (on_axis(end * length), feature)
            };
            rims.map(rim).collect()
        }
        mesh @ Geometry::Mesh { uri, scale, .. } => {
            let hull = meshes.vertices(mesh);
            let vertices = hull.and_then(|hull| mesh_corners(hull, scale, options));
            let vertices =
                vertices.map_err(|reason| format!("the mesh {} {reason}", short_reference(uri)))?;
            vertices.into_iter().map(|c| (c, Feature::Corner)).collect()
        }
    })
}

/// Some vertices of a hull, scaled.
fn mesh_corners(
    hull: &[[f32; 3]],
    scale: &[f64; 3],
    options: &ContactOptions,
) -> Result<Vec<Vector3<f64>>, String> {
    if options.mesh_points == 0 {
        return Err("is left out: mesh_points is 0".into());
    }
    let scaled = |v: &[f32; 3]| Vector3::from_fn(|axis, _| f64::from(v[axis]) * scale[axis]);
    let corners: Vec<Vector3<f64>> = hull.iter().map(scaled).collect();
    if !corners.iter().flatten().all(|x| x.is_finite()) {
        return Err(format!("has no finite size with the scale {scale:?}"));
    }
    Ok(thinned(corners, options.mesh_points))
}

fn corners(size: &[f64; 3]) -> [Vector3<f64>; 8] {
    from_each(|k| {
        let side = |axis: usize| if k >> axis & 1 == 0 { -0.5 } else { 0.5 };
        Vector3::new(side(0) * size[0], side(1) * size[1], side(2) * size[2])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_points_than_memory_has_room_for_are_refused_by_name() {
        assert!(check_memory(64).is_ok());
        let text = check_memory(usize::MAX).unwrap_err().to_string();
        let begin = format!("{} contact points need", usize::MAX);
        assert!(text.starts_with(&begin), "{text}");
    }
}
