//! Boxes: their corners, and the face that lies farthest along a direction.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::rectangle::Rectangle;
use super::when::When;
use crate::scalar::{MapEach, Scalar, from_each};
use crate::spatial::Transform;
use crate::spatial::linear::{columns, dot, scale};

/// Angle within which flat parts may touch at several points, rad: that of plain values.
pub(super) use crate::collision::clip::TOUCHING;

/// A box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cuboid<T> {
    pub(super) center: Vector3<T>,
    pub(super) axes: [Vector3<T>; 3],
    pub(super) half: [T; 3],
}

/// The corners of the face that lies farthest along a direction, in sequence, the farthest first; those that lie as far within an angle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patch<T> {
    pub(super) corners: [Vector3<T>; 4],
    pub(super) present: [When<T>; 4],
    /// Of the face, outward.
    pub(super) normal: Vector3<T>,
}

impl<T: Scalar> Cuboid<T> {
    pub(super) fn new(X: &Transform<T>, half: [T; 3]) -> Self {
        Self {
            center: X.translation,
            axes: columns(&X.rotation),
            half,
        }
    }

    /// From the centre to its surface, along each axis, on the side of a direction.
    pub(super) fn steps(&self, n: &Vector3<T>) -> [Vector3<T>; 3] {
        from_each(|k| {
            let step = scale(&self.axes[k], self.half[k]);
            When::positive(dot(&self.axes[k], n)).signed(&step)
        })
    }

    /// The corner that lies farthest along a direction.
    pub(super) fn support(&self, n: &Vector3<T>) -> Vector3<T> {
        let [x, y, z] = self.steps(n);
        self.center + x + y + z
    }

    /// How far it reaches from its centre along a direction, times the length of that.
    pub(super) fn reach(&self, n: &Vector3<T>) -> T {
        let along = |k: usize| dot(&self.axes[k], n).abs() * self.half[k];
        along(0) + along(1) + along(2)
    }

    /// Lengths of which its points are sums, m.
    pub(super) fn size(&self) -> T {
        self.half[0] + self.half[1] + self.half[2]
    }

    /// The normal of a face, on the side of a direction.
    fn normal(&self, is: &[When<T>; 2], n: &Vector3<T>) -> Vector3<T> {
        let axis = third(is, &self.axes[0], &self.axes[1], &self.axes[2]);
        When::positive(dot(&axis, n)).signed(&axis)
    }

    /// The face across one of its axes on the side of a direction.
    ///
    /// * `is` – whether it is the second axis, the third one
    pub(super) fn face(&self, is: &[When<T>; 2], n: &Vector3<T>) -> Rectangle<T> {
        let [x, y, z] = self.steps(n);
        Rectangle {
            center: self.center + third(is, &x, &y, &z),
            normal: self.normal(is, n),
            axes: [
                third(is, &self.axes[1], &self.axes[2], &self.axes[0]),
                third(is, &self.axes[2], &self.axes[0], &self.axes[1]),
            ],
            half: [
                third_number(is, self.half[1], self.half[2], self.half[0]),
                third_number(is, self.half[2], self.half[0], self.half[1]),
            ],
        }
    }

    /// The corners that lie farthest along a unit direction.
    pub(super) fn patch(&self, n: &Vector3<T>) -> Patch<T> {
        let tilt = self.axes.map_each(|axis| dot(&axis, n).abs().detached());
        let is = is_largest(&tilt);
        let [x, y, z] = self.steps(n);
        let [u, v] = [third(&is, &y, &z, &x), third(&is, &z, &x, &y)];
        let drop: [T; 3] = from_each(|k| tilt[k] * self.half[k].detached());
        let [a, b, c] = self.half.map_each(T::detached);
        let [drop_u, drop_v] = [
            third_number(&is, drop[1], drop[2], drop[0]),
            third_number(&is, drop[2], drop[0], drop[1]),
        ];
        let [h_u, h_v] = [third_number(&is, b, c, a), third_number(&is, c, a, b)];
        let is_near = |drop: T, length: T| When::less(drop, length * TOUCHING);
        let both = drop_u + drop_v;
        let square = (h_u * h_u + h_v * h_v) * (TOUCHING * TOUCHING);
        let has_extents = When::positive(h_u).and(When::positive(h_v));
        let far = self.center + x + y + z;
        let [u, v] = [u + u, v + v];
        Patch {
            corners: [far, far - u, far - u - v, far - v],
            present: [
                When::always(),
                is_near(drop_u, h_u),
                When::less(both * both, square).and(has_extents),
                is_near(drop_v, h_v),
            ],
            normal: self.normal(&is, n),
        }
    }
}

impl<T: Scalar> When<T> {
    /// One box where the condition holds, else another one.
    pub(super) fn pick_box(self, a: &Cuboid<T>, b: &Cuboid<T>) -> Cuboid<T> {
        Cuboid {
            center: self.pick_vector(&a.center, &b.center),
            axes: from_each(|k| self.pick_vector(&a.axes[k], &b.axes[k])),
            half: from_each(|k| self.pick(a.half[k], b.half[k])),
        }
    }
}

/// Whether the second, and whether the third of three numbers is the largest.
pub(super) fn is_largest<T: Scalar>(x: &[T; 3]) -> [When<T>; 2] {
    let first = x[0].max(x[1]);
    [When::less(x[0], x[1]), When::less(first, x[2])]
}

/// The first, second or third number, by [`is_largest`].
pub(super) fn third_number<T: Scalar>(is: &[When<T>; 2], a: T, b: T, c: T) -> T {
    is[1].pick(c, is[0].pick(b, a))
}

/// The first, second or third vector, likewise.
pub(super) fn third<T: Scalar>(
    is: &[When<T>; 2],
    a: &Vector3<T>,
    b: &Vector3<T>,
    c: &Vector3<T>,
) -> Vector3<T> {
    is[1].pick_vector(c, &is[0].pick_vector(b, a))
}
