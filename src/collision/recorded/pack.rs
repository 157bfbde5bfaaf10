//! The candidates of a manifold that are there, in a smaller number of places.

use super::when::When;
use crate::collision::clip::SAME;
use crate::collision::feature::Witness;
use crate::scalar::Scalar;
use crate::spatial::linear::dot;

/// A point that may be one of a manifold.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate<T> {
    pub(super) is: When<T>,
    pub(super) point: Witness<T>,
}

impl<T: Scalar> Candidate<T> {
    /// Only where a condition holds.
    pub(super) fn and(self, is: When<T>) -> Self {
        Self {
            is: self.is.and(is),
            ..self
        }
    }

    /// Also where a condition holds.
    pub(super) fn or_if(self, is: When<T>) -> Self {
        Self {
            is: self.is.or(is),
            ..self
        }
    }
}

/// Leaves out candidates that are where one before them is: corners that coincide are one point.
///
/// * `size` – of both shapes, m
pub(super) fn distinct<T: Scalar>(all: &mut [Candidate<T>], size: T) {
    let least = size * size * (SAME * SAME);
    for k in 1..all.len() {
        let (before, own) = all.split_at_mut(k);
        let [own, ..] = own else { continue };
        let at = own.point.points[0];
        let same = before.iter().map(|other| {
            let apart = at - other.point.points[0];
            other.is.and(When::less(dot(&apart, &apart), least))
        });
        if let Some(any) = same.reduce(When::or) {
            *own = own.and(any.not());
        }
    }
}

/// The candidates that are there, one after the other, and none in places that remain.
pub(super) fn packed<T: Scalar>(all: &[Candidate<T>], places: usize) -> Vec<Witness<T>> {
    let mut count = T::zero();
    let mut numbers = Vec::with_capacity(all.len());
    for own in all {
        numbers.push(own.is.pick(count, -T::one()));
        count += own.is.pick(T::one(), T::zero());
    }
    let place = |place: usize| {
        let number = T::constant(place as f64);
        let mut found = When::positive(-T::one()).only(&all[place.min(all.len() - 1)].point);
        for (own, &at) in all.iter().zip(&numbers).skip(place) {
            let apart = at - number;
            let is = When::less(apart * apart, T::constant(0.25));
            found = is.pick_point(&own.point, &found);
        }
        found
    };
    (0..places).map(place).collect()
}
