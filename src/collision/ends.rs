//! The points at which the sides of two capsules or cylinders lie along one another: the ends of their overlap, on which parallel ones rest.

use nalgebra::Vector3;

use super::corner::{Across, Corner, edge};
use super::feature::{FeatureId, NormalSource, PairFeature};
use super::patch::Patch;
use super::shape::Shape;
use super::solid::Solid;

/// Angle within which two sides lie along one another, rad: some three degrees.
pub(super) const ALONGSIDE: f64 = 0.05;

/// Hands on the pairs of an end of one side and the other side, about a nearest pair of features.
///
/// * `slack` – length by which an end may be beyond the other side, m
pub(super) fn each_end(
    a: &Solid<'_>,
    b: &Solid<'_>,
    pair: &PairFeature,
    slack: f64,
    each: &mut dyn FnMut(PairFeature),
) {
    let [Some(u), Some(v)] = [a, b].map(axis) else {
        return;
    };
    if !are_along(&u, &v) {
        return;
    }
    let n = pair.seed;
    let across = Across::new(&n);
    let first = Patch::new(a, &n, ALONGSIDE, &across);
    let second = Patch::new(b, &-n, ALONGSIDE, &across);
    let ([p, q], [r, s]) = (first.corners(), second.corners()) else {
        return;
    };
    let mut offer = |features| {
        let normal = NormalSource::Features;
        let id = FeatureId { features, normal };
        each(PairFeature { id, seed: n });
    };
    for end in [p, q]
        .into_iter()
        .filter(|end| is_beside(end, [r, s], slack))
    {
        offer([end.feature, edge([r, s])]);
    }
    for end in [r, s]
        .into_iter()
        .filter(|end| is_beside(end, [p, q], slack))
    {
        offer([edge([p, q]), end.feature]);
    }
}

/// The axis of a shape whose side has one direction.
fn axis(solid: &Solid<'_>) -> Option<Vector3<f64>> {
    let has_axis = matches!(solid.shape, Shape::Capsule { .. } | Shape::Cylinder { .. });
    has_axis.then(|| solid.X.rotation.column(2).into_owned())
}

/// * `u`, `v` – unit vectors
fn are_along(u: &Vector3<f64>, v: &Vector3<f64>) -> bool {
    u.cross(v).norm_squared() <= ALONGSIDE * ALONGSIDE
}

/// Whether a corner is between the ends of a side, as seen across it.
fn is_beside(corner: &Corner, [a, b]: [&Corner; 2], slack: f64) -> bool {
    let v = b.point - a.point;
    let (place, length) = (v.dot(&(corner.point - a.point)), v.norm());
    place >= -slack * length && place <= (length + slack) * length
}
