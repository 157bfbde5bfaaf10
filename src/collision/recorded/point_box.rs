//! A point against a box.

use nalgebra::Vector3;

use super::cuboid::Cuboid;
use super::round::Round;
use super::when::When;
use super::{line, nearest as nearest_of_features, vertex};
use crate::collision::feature::{Face, NormalSource, Witness};
use crate::collision::placed::Placed;
use crate::collision::witness::along;
use crate::scalar::{MapEach, Scalar, from_each};
use crate::spatial::linear::{dot, scale};

/// An axis of a box, on the side of a point.
#[derive(Clone, Copy, Debug)]
struct Side<T> {
    axis: Vector3<T>,
    half: T,
    /// By how much the point lies beyond the face, m.
    beyond: T,
}

/// Corner, edge and face of a box that are nearest to a point.
pub(super) struct NearPoint<T> {
    /// Those beyond which the point lies farthest, first.
    sides: [Side<T>; 3],
    corner: Vector3<T>,
    point: Placed<T>,
}

impl<T: Scalar> NearPoint<T> {
    pub(super) fn new(point: Vector3<T>, radius: T, own: &Cuboid<T>) -> Self {
        let from_center = point - own.center;
        let mut sides: [Side<T>; 3] = from_each(|k| {
            let at = dot(&own.axes[k], &from_center);
            Side {
                axis: When::positive(at).signed(&own.axes[k]),
                half: own.half[k],
                beyond: (at.abs() - own.half[k]).detached(),
            }
        });
        for [i, j] in [[0, 1], [1, 2], [0, 1]] {
            let swap = When::less(sides[i].beyond, sides[j].beyond);
            [sides[i], sides[j]] = [swap.pick_side(j, i, &sides), swap.pick_side(i, j, &sides)];
        }
        let steps = sides.map_each(|side| scale(&side.axis, side.half));
        Self {
            sides,
            corner: own.center + steps[0] + steps[1] + steps[2],
            point: vertex(point, radius),
        }
    }

    /// A corner, an edge or a face.
    pub(super) fn nearest(&self) -> Witness<T> {
        let corner = vertex(self.corner, T::zero());
        let edge = line(self.corner, self.sides[2].axis, T::zero());
        let source = NormalSource::Second(Face::Flat(0));
        let at_face = along(&[self.point, corner], &-self.sides[0].axis, source);
        let [at_edge, at_corner] =
            [edge, corner].map_each(|own| nearest_of_features(&[self.point, own]));
        let [_, second, third] = self.sides.map_each(|side| When::positive(side.beyond));
        second.pick_point(&third.pick_point(&at_corner, &at_edge), &at_face)
    }
}

impl<T: Scalar> When<T> {
    /// One side where the condition holds, else another one.
    fn pick_side(self, i: usize, j: usize, sides: &[Side<T>; 3]) -> Side<T> {
        let [a, b] = [&sides[i], &sides[j]];
        Side {
            axis: self.pick_vector(&a.axis, &b.axis),
            half: self.pick(a.half, b.half),
            beyond: self.pick(a.beyond, b.beyond),
        }
    }
}

/// The nearest points of a sphere and a box.
pub(super) fn nearest<T: Scalar>(a: &Round<T>, b: &Cuboid<T>) -> Witness<T> {
    NearPoint::new(a.ends()[0], a.radius, b).nearest()
}
