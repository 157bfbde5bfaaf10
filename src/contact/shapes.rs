//! From the collision shapes of links to the points where they can touch.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::f64::consts::TAU;

use nalgebra::Vector3;

use super::point::{ContactPoint, Feature};
use crate::model::{Collision, Geometry, Model};
use crate::spatial::Transform;

/// Points on each rim of a cylinder: enough to stand on.
const RIM_POINTS: usize = 3;

/// A collision shape without points.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UntouchedShape {
    /// The link.
    pub link: String,
    /// What it is, and why it cannot touch.
    pub reason: String,
}

/// The points of all collision shapes of a robot, and the shapes that have none. What is fixed to the world touches nothing.
pub(super) fn points_of(model: &Model) -> (Vec<ContactPoint>, Vec<UntouchedShape>) {
    let (mut points, mut untouched) = (Vec::new(), Vec::new());
    for link in model.links() {
        let frame = &model.frames()[link.frame.0];
        let Some(body) = frame.body else { continue };
        for shape in &link.collisions {
            let found = features(shape);
            if let Err(reason) = &found {
                untouched.push(UntouchedShape {
                    link: frame.name.clone(),
                    reason: reason.clone(),
                });
            }
            let X_BS = frame.placement * shape.placement;
            let placed = found.unwrap_or_default().into_iter();
            points.extend(placed.map(|(center, feature)| ContactPoint {
                link: link.frame,
                body,
                center: X_BS.point(&center),
                feature: turned(&X_BS, feature),
            }));
        }
    }
    (points, untouched)
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
        other => other,
    }
}

/// Centres and features in the frame of the shape.
fn features(shape: &Collision) -> Result<Vec<(Vector3<f64>, Feature)>, String> {
    let on_axis = |z: f64| Vector3::new(0.0, 0.0, z);
    Ok(match &shape.geometry {
        Geometry::Sphere { radius } => {
            vec![(Vector3::zeros(), Feature::Sphere { radius: *radius })]
        }
        Geometry::Capsule { radius, length } => [-0.5, 0.5]
            .map(|end| (on_axis(end * length), Feature::Sphere { radius: *radius }))
            .to_vec(),
        Geometry::Box { size } => corners(size).map(|c| (c, Feature::Corner)).to_vec(),
        Geometry::Cylinder { radius, length } => {
            let ends = [-0.5, 0.5].into_iter();
            let rims = ends.flat_map(|end| (0..RIM_POINTS).map(move |k| (end, k)));
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
        Geometry::Mesh { uri, .. } => {
            return Err(format!("the mesh {uri} has not been loaded"));
        }
    })
}

fn corners(size: &[f64; 3]) -> [Vector3<f64>; 8] {
    std::array::from_fn(|k| {
        let side = |axis: usize| if k >> axis & 1 == 0 { -0.5 } else { 0.5 };
        Vector3::new(side(0) * size[0], side(1) * size[1], side(2) * size[2])
    })
}
