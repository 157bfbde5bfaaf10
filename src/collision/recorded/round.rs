//! Spheres and capsules: points and segments with a radius around them.

use nalgebra::Vector3;

use super::pack::{Candidate, distinct, packed};
use super::when::{Nearest, When};
use super::{EQUAL, PARALLEL, SEED, line, nearest as nearest_of_features, vertex};
use crate::collision::ends::ALONGSIDE;
use crate::collision::feature::{NormalSource, Witness};
use crate::collision::placed::{Core, Placed};
use crate::collision::witness::{along, nearest_normal};
use crate::nested::IntoNested;
use crate::scalar::Scalar;
use crate::spatial::linear::{cross, dot};

/// Most points of two segments: the nearest one between the ends of their overlap.
pub(super) const MOST_ALONG: usize = 3;

/// A point or a segment with a radius around it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Round<T> {
    ends: [Vector3<T>; 2],
    pub(super) is_point: bool,
    pub(super) radius: T,
}

impl<T: Scalar> Round<T> {
    pub(super) fn point(center: Vector3<T>, radius: T) -> Self {
        Self {
            ends: [center; 2],
            is_point: true,
            radius,
        }
    }

    pub(super) fn segment(ends: [Vector3<T>; 2], radius: T) -> Self {
        Self {
            ends,
            is_point: false,
            radius,
        }
    }

    /// The centre of a sphere, or both ends of a segment.
    pub(super) fn ends(&self) -> &[Vector3<T>] {
        if self.is_point {
            &self.ends[..1]
        } else {
            &self.ends
        }
    }

    /// From the first end to the second.
    pub(super) fn direction(&self) -> Vector3<T> {
        self.ends[1] - self.ends[0]
    }

    pub(super) fn vertices(&self) -> impl Iterator<Item = Placed<T>> + '_ {
        self.ends().iter().map(|&end| vertex(end, self.radius))
    }

    /// The line of a segment; `None` for a sphere.
    pub(super) fn line(&self) -> Option<Placed<T>> {
        let line = || line(self.ends[0], self.direction(), self.radius);
        (!self.is_point).then(line)
    }

    /// Whether a point of the line, or beside it, lies between the ends.
    pub(super) fn is_beside(&self, point: &Vector3<T>) -> When<T> {
        let u = self.direction();
        let place = dot(&u, &(point - self.ends[0]));
        When::positive(place).and(When::less(place, dot(&u, &u)))
    }

    /// Whether a point, seen across the segment, lies between its ends or beyond one of them by rounding.
    fn is_within(&self, point: &Vector3<T>) -> When<T> {
        let u = self.direction();
        let (place, square) = (dot(&u, &(point - self.ends[0])), dot(&u, &u));
        let beyond = square * EQUAL;
        When::positive(place + beyond).and(When::less(place, square + beyond))
    }
}

/// The nearest points of two of them.
pub(super) fn nearest<T: Scalar>(a: &Round<T>, b: &Round<T>) -> Witness<T> {
    let pairs = a.vertices().nested(|p| b.vertices().map(move |q| [p, q]));
    let mut found = pairs.map(|pair| nearest_of_features(&pair));
    let first = found.next().expect("each has an end");
    let mut best = Nearest(first);
    found.for_each(|own| best.offer(When::always(), &own));
    if let Some(v) = b.line() {
        for p in a.vertices() {
            let own = nearest_of_features(&[p, v]);
            best.offer(b.is_beside(&own.points[1]), &own);
        }
    }
    if let Some(u) = a.line() {
        for q in b.vertices() {
            let own = nearest_of_features(&[u, q]);
            best.offer(a.is_beside(&own.points[0]), &own);
        }
    }
    if let (Some(u), Some(v)) = (a.line(), b.line()) {
        let (cross, own) = crossing(&[u, v], &(v.center - u.center));
        let on_both = a.is_beside(&own.points[0]).and(b.is_beside(&own.points[1]));
        best.offer(cross.and(on_both), &own);
    }
    best.0
}

/// The points of two of them: the nearest, and ends of their overlap where both are segments that lie along one another.
pub(super) fn points<T: Scalar>(a: &Round<T>, b: &Round<T>) -> Vec<Witness<T>> {
    let first = nearest(a, b);
    let (Some(u), Some(v)) = (a.line(), b.line()) else {
        return vec![first];
    };
    let (is, point) = (When::always(), first);
    let mut all = vec![Candidate { is, point }];
    let are_along = sine_is_less(&[u, v], ALONGSIDE);
    for p in a.vertices() {
        let point = nearest_of_features(&[p, v]);
        let is = b.is_within(&p.center).and(are_along);
        all.push(Candidate { is, point });
    }
    for q in b.vertices() {
        let point = nearest_of_features(&[u, q]);
        let is = a.is_within(&q.center).and(are_along);
        all.push(Candidate { is, point });
    }
    let size = [a, b].map(|own| dot(&own.direction(), &own.direction()).sqrt() * 0.5 + own.radius);
    distinct(&mut all, (size[0] + size[1]).detached());
    packed(&all, MOST_ALONG)
}

/// The points at which two lines are nearest, where they are not parallel, with the normal towards a direction.
pub(super) fn crossing<T: Scalar>(
    lines: &[Placed<T>; 2],
    toward: &Vector3<T>,
) -> (When<T>, Witness<T>) {
    let normal = nearest_normal(lines, &SEED);
    let forward = When::less(dot(&normal, toward), T::zero()).not();
    let own = along(lines, &forward.signed(&normal), NormalSource::Features);
    (cross_each_other(lines), own)
}

/// Whether two lines are not parallel.
fn cross_each_other<T: Scalar>(lines: &[Placed<T>; 2]) -> When<T> {
    sine_is_less(lines, PARALLEL).not()
}

/// Whether the sine of the angle between two lines is at most a number.
fn sine_is_less<T: Scalar>([a, b]: &[Placed<T>; 2], most: f64) -> When<T> {
    let (Core::Line(u), Core::Line(v)) = (&a.core, &b.core) else {
        return When::always().not();
    };
    let product = cross(u, v);
    let largest = dot(u, u) * dot(v, v) * (most * most);
    When::less(largest, dot(&product, &product)).not()
}
