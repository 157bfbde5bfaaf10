//! Collision shapes for the HTML viewer with sliders, which marks collisions.

use crate::nested::IntoNested;
use serde::Serialize;

use super::blob::Blob;
use super::shape::{Pose, pose};
use crate::collision::Shape;
use crate::contact::{LinkShape, LinkShapes};
use crate::model::{FrameId, Model};
use crate::scalar::MapEach;

/// More pairs are not looked at while a slider moves.
const MAX_PAIRS: usize = 20_000;

/// Collision shapes, and the pairs of them that may touch.
#[derive(Debug, Serialize)]
pub(super) struct Collisions {
    shapes: Vec<CollisionShape>,
    pairs: Vec<[usize; 2]>,
    /// Pairs of links that touch at the neutral configuration, and so are not looked at: neighbours of neighbours mostly.
    touching: Vec<[String; 2]>,
}

/// A shape as the convex hull of points or of a disc, with a radius around it.
#[derive(Debug, Serialize)]
struct CollisionShape {
    body: Option<usize>,
    link: String,
    pose: Pose,
    /// Points x, y, z.
    points: Blob,
    /// Radius of the disc about z at each point, m.
    disc: f64,
    /// Radius around the hull, m.
    radius: f64,
}

/// Data for the marks of collisions in the viewer; `None` if nothing can collide.
pub(super) fn collisions(model: &Model) -> Option<Collisions> {
    let mut shapes = LinkShapes::new(model);
    let touching = shapes.touching(model, model.neutral().as_slice());
    let touching = touching.ok()?;
    shapes.exclude(model, &touching).ok()?;
    let n = shapes.shapes().len();
    let all = (0..n).nested(|j| (0..j).map(move |i| [i, j]));
    let pairs = all.filter(|[i, j]| shapes.may_touch(*i, *j));
    let pairs: Vec<_> = pairs.take(MAX_PAIRS + 1).collect();
    if pairs.is_empty() || pairs.len() > MAX_PAIRS {
        return None;
    }
    let name = |link: FrameId| model.frames()[link.0].name.clone();
    let own = shapes.shapes().iter();
    Some(Collisions {
        shapes: own
            .map(|own| shape(own, name(own.link)))
            .collect::<Option<_>>()?,
        pairs,
        touching: touching
            .iter()
            .map(|pair| pair.map(str::to_owned))
            .collect(),
    })
}

/// The shape of a link; `None` for one without end.
fn shape(own: &LinkShape, link: String) -> Option<CollisionShape> {
    let ends = |half: f64| vec![0.0, 0.0, -half, 0.0, 0.0, half];
    let (points, disc, radius) = match &own.shape {
        Shape::Sphere { radius } => (vec![0.0; 3], 0.0, *radius),
        Shape::Capsule {
            radius,
            half_length,
        } => (ends(*half_length), 0.0, *radius),
        Shape::Cylinder {
            radius,
            half_length,
        } => (ends(*half_length), *radius, 0.0),
        Shape::Box {
            half_extents: [x, y, z],
        } => {
            let signs =
                |k: usize| [0, 1, 2].map_each(|axis| if k >> axis & 1 == 0 { -1.0 } else { 1.0 });
            let corner = |k| {
                signs(k)
                    .into_iter()
                    .zip([x, y, z])
                    .map(|(s, half)| s * half)
            };
            ((0..8).nested(corner).collect(), 0.0, 0.0)
        }
        Shape::Hull { hull, scale } => {
            let scaled = |v: &nalgebra::Vector3<f64>| [0, 1, 2].map_each(|k| v[k] * scale[k]);
            (hull.vertices().iter().nested(scaled).collect(), 0.0, 0.0)
        }
        _ => return None,
    };
    Some(CollisionShape {
        body: own.body.map(|body| body.0),
        link,
        pose: pose(&own.placement),
        points: Blob::f32(points),
        disc,
        radius,
    })
}
