//! The shapes of a link whose sizes have changed: what is shown and what touches.

use nalgebra::Vector3;

use super::dimension::{resized, sizes_of};
use super::link::Scaled;
use super::stretch::Stretch;
use crate::model::{Geometry, LinkSpec};
use crate::spatial::Transform;

/// Moves and resizes all shapes of a link.
///
/// * `x` – all parameters
pub(super) fn rescale(link: &mut LinkSpec, scaled: &Scaled, stretch: &Stretch<f64>, x: &[f64]) {
    let chosen = resized(&scaled.geometry, &scaled.sizes(x));
    let change = |pose: &mut Transform<f64>, shape: &mut Geometry| {
        let is_like_chosen = *shape == scaled.geometry && pose.rotation == scaled.X_LG.rotation;
        *shape = if is_like_chosen {
            chosen.clone()
        } else {
            stretched(shape, pose, stretch)
        };
        pose.translation += stretch.displacement(&pose.translation);
    };
    for visual in &mut link.visuals {
        change(&mut visual.placement, &mut visual.geometry);
    }
    for collision in &mut link.collisions {
        change(&mut collision.placement, &mut collision.geometry);
    }
}

/// A shape of the same kind, each length of which is stretched as its direction is.
fn stretched(shape: &Geometry, pose: &Transform<f64>, stretch: &Stretch<f64>) -> Geometry {
    let axis = |k: usize| Vector3::from(pose.rotation.column(k));
    let factors = match shape {
        Geometry::Box { .. } | Geometry::Ellipsoid { .. } | Geometry::Mesh { .. } => {
            (0..3).map(|k| stretch.along(&axis(k))).collect()
        }
        Geometry::Cylinder { .. } | Geometry::Capsule { .. } => {
            vec![stretch.across(&axis(2)), stretch.along(&axis(2))]
        }
        Geometry::Sphere { .. } => vec![stretch.ball()],
    };
    let sizes = sizes_of(shape).into_iter().zip(factors);
    resized(
        shape,
        &sizes
            .map(|(size, factor)| size * factor)
            .collect::<Vec<_>>(),
    )
}
