//! The angular error of a regularised weld.

use nalgebra::{DMatrix, Vector3};

use super::anchor::AnchorMotion;
use crate::scalar::{MapEach, Scalar};
use crate::spatial::Quaternion;
use crate::spatial::linear::{columns, cross, dot, from_columns, rotate, rotate_back};

/// Rotation from one anchor to another about the unit vector n in the axes of the world: p = sin(θ/2) n, c = cos(θ/2).
///
/// The error is φ = 2 p. With the relative angular velocity ω and acceleration α, seen from the first anchor, which turns at ω₁,
///
/// > φ̇ = c ω + ω × p  and  φ̈ = c α + α × p − ½ |ω|² p  with  α = α₂ − α₁ − ω₁ × ω:
///
/// the derivatives of the quaternion along the axes of that anchor, Q̇ = ½ ω Q and Q̈ = ½ α Q − ¼ |ω|² Q.
pub(super) struct WeldAngle<T> {
    c: T,
    p: Vector3<T>,
}

impl<T: Scalar> WeldAngle<T> {
    pub(super) fn between([from, to]: &[AnchorMotion<T>; 2]) -> Self {
        let axes = columns(&to.X.rotation).map_each(|axis| rotate_back(&from.X.rotation, &axis));
        let [x, y, z] = &axes;
        let Quaternion { w, xyz } = Quaternion::from_matrix(&from_columns(x, y, z));
        Self {
            c: w,
            p: rotate(&from.X.rotation, &xyz),
        }
    }

    /// |φ|².
    pub(super) fn square(&self) -> T {
        dot(&self.p, &self.p) * 4.0
    }

    /// aₖ with φ̇ₖ = aₖ · ω.
    fn axis(&self, k: usize) -> Vector3<T> {
        let e = Vector3::from_fn(|i, _| if i == k { T::one() } else { T::zero() });
        e * self.c + cross(&self.p, &e)
    }

    /// Passes error, rate and bias of each row with its axis to `each`.
    pub(super) fn each_row(
        &self,
        [from, to]: &[AnchorMotion<T>; 2],
        mut each: impl FnMut([T; 3], Vector3<T>),
    ) {
        let omega = to.V.angular - from.V.angular;
        let seen = to.A.angular - from.A.angular - cross(&from.V.angular, &omega);
        let square = dot(&omega, &omega) * 0.5;
        for k in 0..3 {
            let axis = self.axis(k);
            let bias = dot(&axis, &seen) - square * self.p[k];
            each([self.p[k] * 2.0, dot(&axis, &omega), bias], axis);
        }
    }

    /// Makes of the rows of ω of a Jacobian, which are its last three, those of φ̇.
    pub(super) fn turn(&self, jacobian: &mut DMatrix<T>) {
        let axes = [self.axis(0), self.axis(1), self.axis(2)];
        for mut column in jacobian.column_iter_mut() {
            let omega = Vector3::new(column[3], column[4], column[5]);
            for (k, axis) in axes.iter().enumerate() {
                column[3 + k] = dot(axis, &omega);
            }
        }
    }
}
