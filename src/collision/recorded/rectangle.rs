//! The face of a box on which corners of another shape lie, and whose sides those of the other shape cross.

use nalgebra::Vector3;

use super::pack::Candidate;
use super::when::When;
use super::{line, vertex};
use crate::collision::clip::{ALONG, SLACK};
use crate::collision::feature::{Face, NormalSource, Witness};
use crate::collision::placed::Placed;
use crate::collision::witness::along;
use crate::scalar::{MapEach, Scalar};
use crate::spatial::linear::{dot, scale};

/// A face of a box, about its centre.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rectangle<T> {
    pub(super) center: Vector3<T>,
    /// Outward.
    pub(super) normal: Vector3<T>,
    pub(super) axes: [Vector3<T>; 2],
    pub(super) half: [T; 2],
}

/// A side that the side of another shape crosses.
struct CrossedSide<T> {
    is: When<T>,
    center: Vector3<T>,
    along: Vector3<T>,
}

impl<T: Scalar> Rectangle<T> {
    /// Where a point lies on it, from its centre along both axes.
    pub(super) fn place(&self, point: &Vector3<T>) -> [T; 2] {
        let apart = point - self.center;
        self.axes.map_each(|axis| dot(&axis, &apart))
    }

    /// Its corners, in sequence.
    pub(super) fn corners(&self) -> [Vector3<T>; 4] {
        let u = scale(&self.axes[0], self.half[0]);
        let v = scale(&self.axes[1], self.half[1]);
        [u + v, u - v, -u - v, v - u].map_each(|step| self.center + step)
    }

    /// A corner of another shape where it lies over the face.
    pub(super) fn corner(&self, corner: Vector3<T>, radius: T) -> Candidate<T> {
        let place = self.place(&corner);
        let inside = |k: usize| {
            let edge = self.half[k] * (1.0 + SLACK) + f64::MIN_POSITIVE;
            When::less(place[k].abs(), edge)
        };
        Candidate {
            is: inside(0).and(inside(1)),
            point: self.point([vertex(corner, radius), vertex(self.center, T::zero())]),
        }
    }

    /// The points at which the side of another shape enters the face and leaves it.
    ///
    /// * `from`, `to` – ends of the side
    pub(super) fn crossings(
        &self,
        from: &Vector3<T>,
        to: &Vector3<T>,
        radius: T,
    ) -> [Candidate<T>; 2] {
        let ends = [self.place(from), self.place(to)];
        let other = line(*from, to - from, radius);
        [false, true].map_each(|leaves| {
            let [a, b] = [0, 1].map(|k| self.crossed(k, &ends, leaves));
            let center = a.is.pick_vector(&a.center, &b.center);
            let side = line(center, a.is.pick_vector(&a.along, &b.along), T::zero());
            Candidate {
                is: a.is.or(b.is),
                point: self.point([other, side]),
            }
        })
    }

    /// Whether a line between two places enters the face, or leaves it, across a side at one end of an axis.
    fn crossed(&self, axis: usize, ends: &[[T; 2]; 2], leaves: bool) -> CrossedSide<T> {
        let [own, other] =
            [axis, 1 - axis].map_each(|k| [ends[0][k], ends[1][k]].map_each(T::detached));
        let [u, v] = [own, other].map_each(|[from, to]| to - from);
        let half = [axis, 1 - axis].map_each(|k| self.half[k].detached());
        let is_steep = When::less((u * u + v * v) * (ALONG * ALONG), u * u);
        let ahead = When::positive(if leaves { u } else { -u });
        let edge = ahead.pick(half[0], -half[0]);
        let place = (edge - own[0]) / is_steep.pick(u, T::one());
        let between = When::positive(place).and(When::less(place, T::one()));
        let across = v.mul_add(place, other[0]);
        let inside = When::less(across.abs(), half[1]);
        let step = scale(&self.axes[axis], self.half[axis]);
        CrossedSide {
            is: is_steep.and(between).and(inside),
            center: self.center + ahead.signed(&step),
            along: self.axes[1 - axis],
        }
    }

    /// Features of another shape and of the face, seen along its normal.
    pub(super) fn point(&self, placed: [Placed<T>; 2]) -> Witness<T> {
        let source = NormalSource::Second(Face::Flat(0));
        along(&placed, &-self.normal, source)
    }
}
