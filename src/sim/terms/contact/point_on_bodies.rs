//! Where the bodies of a contact point are: its velocity, and forces along its axes on both bodies, whatever its law.
//!
//! Apart from the laws, as it does not depend on the scalar of their numbers: it is compiled once for all of these.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{Matrix3, Vector3};

use crate::contact::{ContactRow, PointState, ROWS, body_force, velocity_at};
use crate::scalar::{Dual, Scalar, from_each, vectorized};
use crate::sim::terms::local::{OfBody, constant_motion};
use crate::spatial::linear::{dot, rotate, rotate_back};
use crate::spatial::{Force, Motion};

/// A point of contact on its bodies, on dual numbers.
pub(super) struct PointOnBodies<T: Scalar> {
    /// Axes of its body in the world.
    pub(super) R_WB: Matrix3<OfBody<T>>,
    pub(super) point: PointState<OfBody<T>>,
    /// Where it is a point between bodies.
    pub(super) second: Option<SecondBody<T>>,
    pub(super) axes: [Vector3<OfBody<T>>; ROWS],
}

/// The second body at a point between bodies.
pub(super) struct SecondBody<T: Scalar> {
    pub(super) R_WB: Matrix3<OfBody<T>>,
    /// Position of the point in it, m.
    pub(super) in_body: Vector3<OfBody<T>>,
}

impl<T: Scalar> PointOnBodies<T> {
    /// y of rows along the axes.
    pub(super) fn y_of(
        &self,
        own: &[ContactRow<OfBody<T>>; ROWS],
        acceleration: &Vector3<OfBody<T>>,
        forces: &[T],
    ) -> [OfBody<T>; ROWS] {
        from_each(|row| {
            let y = own[row].y_at_rest(forces[row]);
            let along = || dot(&self.axes[row], acceleration);
            y.map_or(Dual::from(0.0), |y| along() + y)
        })
    }

    /// The velocity of the first body at the point, less that of the second.
    pub(super) fn velocity(&self, V: &[Motion<T>; 2]) -> Vector3<OfBody<T>> {
        let first = vectorized(
            #[inline(always)]
            || {
                let V = constant_motion(&V[0]);
                self.point.velocity_of(&self.R_WB, &V)
            },
        );
        match &self.second {
            None => first,
            Some(second) => first - second.velocity(&V[1]),
        }
    }

    /// Rate of rotation of the first body against the second, in the world.
    pub(super) fn turning_rate(&self, V: &[Motion<T>; 2]) -> Vector3<OfBody<T>> {
        let rotated =
            |R: &Matrix3<OfBody<T>>, V: &Motion<T>| rotate(R, &V.angular.map(OfBody::constant_of));
        let first = rotated(&self.R_WB, &V[0]);
        match &self.second {
            None => first,
            Some(second) => first - rotated(&second.R_WB, &V[1]),
        }
    }

    pub(super) fn along_axes(&self, x: &[T]) -> Vector3<OfBody<T>> {
        let parts = self.axes.iter().zip(x);
        parts.fold(Vector3::zeros(), |sum, (axis, &x)| {
            sum + axis.map(|own| own.each(|own| own * x))
        })
    }

    /// A force in the world on the first body, and its opposite on the second one, each in its body.
    pub(super) fn forces(&self, force: &Vector3<OfBody<T>>) -> [Option<Force<OfBody<T>>>; 2] {
        let second = self.second.as_ref();
        [
            Some(self.on_first(force)),
            second.map(|second| second.force(&-force)),
        ]
    }

    fn on_first(&self, force: &Vector3<OfBody<T>>) -> Force<OfBody<T>> {
        vectorized(
            #[inline(always)]
            || body_force(&self.R_WB, &self.point.in_body, force),
        )
    }

    /// A moment in the world on the first body, and its opposite on the second one, each in its body.
    pub(super) fn couples(&self, moment: &Vector3<OfBody<T>>) -> [Option<Force<OfBody<T>>>; 2] {
        let on = |R: &Matrix3<OfBody<T>>, moment: &Vector3<OfBody<T>>| {
            Force::new(Vector3::zeros(), rotate_back(R, moment))
        };
        let second = self.second.as_ref();
        [
            Some(on(&self.R_WB, moment)),
            second.map(|second| on(&second.R_WB, &-moment)),
        ]
    }
}

impl<T: Scalar> SecondBody<T> {
    fn velocity(&self, V: &Motion<T>) -> Vector3<OfBody<T>> {
        rotate(&self.R_WB, &velocity_at(&constant_motion(V), &self.in_body))
    }

    fn force(&self, force: &Vector3<OfBody<T>>) -> Force<OfBody<T>> {
        body_force(&self.R_WB, &self.in_body, force)
    }
}
