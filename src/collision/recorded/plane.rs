//! Half-spaces: the corners of another shape that lie deepest.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::cuboid::{Cuboid, TOUCHING};
use super::round::Round;
use super::vertex;
use super::when::When;
use crate::collision::feature::{Face, NormalSource, Witness};
use crate::collision::witness::along;
use crate::scalar::{MapEach, Scalar};
use crate::spatial::Transform;
use crate::spatial::linear::{columns, dot};

/// A plane with an outward unit normal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane<T> {
    point: Vector3<T>,
    normal: Vector3<T>,
}

impl<T: Scalar> Plane<T> {
    pub(super) fn new(X: &Transform<T>) -> Self {
        Self {
            point: X.translation,
            normal: columns(&X.rotation)[2],
        }
    }

    /// A corner, with a radius around it, against the plane.
    fn point(&self, corner: Vector3<T>, radius: T) -> Witness<T> {
        let placed = [vertex(corner, radius), vertex(self.point, T::zero())];
        along(&placed, &-self.normal, NormalSource::Second(Face::Plane))
    }

    /// The deepest end of a capsule, and the other one if it lies as deep within an angle; the centre of a sphere.
    pub(super) fn points_of_round(&self, own: &Round<T>) -> Vec<Witness<T>> {
        let &[below, above] = own.ends() else {
            return vec![self.point(own.ends()[0], own.radius)];
        };
        let (far, other, near) = deepest(&[below, above], &-self.normal);
        let [far, other] = [far, other].map_each(|end| self.point(end, own.radius));
        vec![far, near.only(&other)]
    }

    /// The deepest corner of a box, and those of its face that lie as deep within an angle.
    pub(super) fn points_of_box(&self, own: &Cuboid<T>) -> Vec<Witness<T>> {
        let patch = own.patch(&-self.normal);
        let corners = patch.corners.iter().zip(patch.present);
        let points = corners.map(|(&corner, is)| is.only(&self.point(corner, T::zero())));
        points.collect()
    }
}

/// The end of a segment that lies farthest along a unit direction, the other end, and whether it lies as far within an angle.
pub(super) fn deepest<T: Scalar>(
    [below, above]: &[Vector3<T>; 2],
    n: &Vector3<T>,
) -> (Vector3<T>, Vector3<T>, When<T>) {
    let u = above - below;
    let rise = dot(&u, n);
    let up = When::positive(rise);
    let near = When::less(rise * rise, dot(&u, &u) * (TOUCHING * TOUCHING));
    let far = up.pick_vector(above, below);
    (far, up.pick_vector(below, above), near)
}
