//! Poses of frames and the maps that they define.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::ops::Mul;

use nalgebra::{Isometry3, Matrix3, Vector3};

use super::linear::{
    add_cross, add_cross_data, lift_matrix, lift_vector, matrix_times_data, rotate, rotate_back,
    rotate_back_data, rotate_back_plus, rotate_data, sub_cross_data,
};
use super::{Force, Inertia, Motion};
use crate::numbers::numbers;
use crate::scalar::{Cast, Linear, Over, Scalar};

/// Numbers in a transform: those of a rotation matrix and a vector.
pub(crate) const TRANSFORM_ENTRIES: usize = 12;

/// The pose `X_AB` of frame B in frame A; it maps quantities expressed in B to A.
///
/// # Examples
/// ```
/// use dualbody::spatial::Transform;
/// use nalgebra::Vector3;
///
/// let X_AB = Transform::from_translation(Vector3::new(1.0, 0.0, 0.0));
/// assert_eq!((X_AB * X_AB).translation.x, 2.0);
/// assert_eq!(X_AB.inverse().point(&Vector3::zeros()).x, -1.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform<T> {
    /// Rotation `R_AB`: its columns are the axes of B in A.
    pub rotation: Matrix3<T>,
    /// Position `p_AB_A` of B's origin in A, m.
    pub translation: Vector3<T>,
}

numbers! { struct Transform { rotation: hidden(), translation: hidden() } }

impl<T: Scalar> Transform<T> {
    /// Makes a transform `X_AB` from the rotation `R_AB` and the position `p_AB_A`, m. The rotation is not checked.
    #[inline(always)]
    pub fn new(rotation: Matrix3<T>, translation: Vector3<T>) -> Self {
        Self {
            rotation,
            translation,
        }
    }

    /// Identity: frames B and A coincide.
    #[inline]
    pub fn identity() -> Self {
        Self::new(Matrix3::identity(), Vector3::zeros())
    }

    /// Makes a transform without rotation: B has A's axes, and its origin at `translation` in A, m.
    #[inline]
    pub fn from_translation(translation: Vector3<T>) -> Self {
        Self::new(Matrix3::identity(), translation)
    }

    /// Entries: the rotation row by row, then the translation.
    #[inline(always)]
    pub(crate) fn to_entries(self) -> [T; TRANSFORM_ENTRIES] {
        let (r, p) = (&self.rotation, &self.translation);
        [
            r.m11, r.m12, r.m13, r.m21, r.m22, r.m23, r.m31, r.m32, r.m33, p.x, p.y, p.z,
        ]
    }

    /// Makes a transform from the rotation row by row, then the translation.
    #[inline(always)]
    pub(crate) fn from_entries(x: [T; TRANSFORM_ENTRIES]) -> Self {
        Self::new(
            Matrix3::new(x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7], x[8]),
            Vector3::new(x[9], x[10], x[11]),
        )
    }

    /// Computes the inverse transform, `X_BA` from `X_AB`.
    #[inline]
    pub fn inverse(&self) -> Self {
        Self::new(
            self.rotation.transpose(),
            -rotate_back(&self.rotation, &self.translation),
        )
    }

    /// Transforms a point from B to A, m: p + R `p_B`.
    #[inline(always)]
    pub fn point(&self, p_B: &Vector3<T>) -> Vector3<T> {
        rotate(&self.rotation, p_B) + self.translation
    }

    /// Transforms a motion vector from B to A: (R v + p × R ω; R ω) [Featherstone 2008, 2.24].
    #[inline(always)]
    pub fn motion<S: Linear<T>>(&self, V_B: &Motion<S>) -> Motion<S> {
        let angular = rotate(&self.rotation, &V_B.angular);
        let turned = rotate(&self.rotation, &V_B.linear);
        Motion::new(
            sub_cross_data(&turned, &angular, &self.translation),
            angular,
        )
    }

    /// Transforms a motion vector from A to B, the inverse of [`motion`](Self::motion).
    #[inline(always)]
    pub fn motion_inverse<S: Linear<T>>(&self, V_A: &Motion<S>) -> Motion<S> {
        let linear = add_cross_data(&V_A.linear, &V_A.angular, &self.translation);
        Motion::new(
            rotate_back(&self.rotation, &linear),
            rotate_back(&self.rotation, &V_A.angular),
        )
    }

    /// Transforms a motion vector of model data from A to B.
    #[inline(always)]
    pub(crate) fn data_motion_inverse<P: Scalar>(&self, V_A: &Motion<P>) -> Motion<T>
    where
        T: Over<P>,
    {
        let linear = sub_cross_data(&lift_vector(&V_A.linear), &self.translation, &V_A.angular);
        Motion::new(
            rotate_back(&self.rotation, &linear),
            rotate_back_data(&self.rotation, &V_A.angular),
        )
    }

    /// Transforms a motion vector from A to B, and adds one in B.
    #[inline(always)]
    pub(crate) fn motion_inverse_plus(&self, V_A: &Motion<T>, V_B: &Motion<T>) -> Motion<T> {
        let linear = add_cross(&V_A.linear, &V_A.angular, &self.translation);
        Motion::new(
            rotate_back_plus(&self.rotation, &linear, &V_B.linear),
            rotate_back_plus(&self.rotation, &V_A.angular, &V_B.angular),
        )
    }

    /// Transforms a force from B to A: (R f; R n + p × R f) [Featherstone 2008, 2.25].
    #[inline(always)]
    pub fn force<S: Linear<T>>(&self, F_B: &Force<S>) -> Force<S> {
        let linear = rotate(&self.rotation, &F_B.linear);
        let turned = rotate(&self.rotation, &F_B.angular);
        Force::new(linear, sub_cross_data(&turned, &linear, &self.translation))
    }

    /// A force from B to A that is data.
    #[inline(always)]
    pub(crate) fn data_force<P: Scalar>(&self, F_B: &Force<P>) -> Force<T>
    where
        T: Over<P>,
    {
        let linear = rotate_data(&self.rotation, &F_B.linear);
        let turned = rotate_data(&self.rotation, &F_B.angular);
        Force::new(
            linear,
            sub_cross_data::<T, T>(&turned, &linear, &self.translation),
        )
    }

    /// Transforms a spatial force from A to B, the inverse of [`force`](Self::force).
    #[inline(always)]
    pub(crate) fn force_inverse<S: Linear<T>>(&self, F_A: &Force<S>) -> Force<S> {
        let angular = add_cross_data(&F_A.angular, &F_A.linear, &self.translation);
        Force::new(
            rotate_back(&self.rotation, &F_A.linear),
            rotate_back(&self.rotation, &angular),
        )
    }

    /// Transforms the inertia of a rigid body from B to A.
    #[inline(always)]
    pub fn inertia(&self, I_B: &Inertia<T>) -> Inertia<T> {
        I_B.moved(&self.rotation, &self.translation)
    }

    /// `X_AC = X_AB X_BC` for model data `X_BC` (self) after the pose `X_AB` of another scalar.
    #[inline(always)]
    pub(crate) fn after<S: Over<T>>(&self, X_AB: &Transform<S>) -> Transform<S> {
        Transform::new(
            matrix_times_data(&X_AB.rotation, &self.rotation),
            rotate_data(&X_AB.rotation, &self.translation) + X_AB.translation,
        )
    }

    /// Lifts the pose to another scalar.
    #[inline(always)]
    pub(crate) fn lift<S: Over<T>>(&self) -> Transform<S> {
        Transform::new(lift_matrix(&self.rotation), lift_vector(&self.translation))
    }
}

impl<P: Scalar> Cast<P> for Transform<P> {
    type To<Q: Scalar> = Transform<Q>;

    fn cast<Q: Over<P>>(&self) -> Transform<Q> {
        self.lift()
    }
}

impl<T: Scalar> Mul for Transform<T> {
    type Output = Self;

    /// `X_AC = X_AB * X_BC`.
    #[inline(always)]
    fn mul(self, X_BC: Self) -> Self {
        X_BC.after::<T>(&self)
    }
}

impl From<Transform<f64>> for Isometry3<f64> {
    fn from(X_AB: Transform<f64>) -> Self {
        let rotation = nalgebra::Rotation3::from_matrix_unchecked(X_AB.rotation);
        Self::from_parts(
            X_AB.translation.into(),
            nalgebra::UnitQuaternion::from_rotation_matrix(&rotation),
        )
    }
}

impl From<Isometry3<f64>> for Transform<f64> {
    fn from(X_AB: Isometry3<f64>) -> Self {
        Self::new(
            *X_AB.rotation.to_rotation_matrix().matrix(),
            X_AB.translation.vector,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spatial::Quaternion;
    use crate::tests::ROUNDING;
    use approx::assert_relative_eq;

    fn poses() -> (Transform<f64>, Transform<f64>) {
        (
            Transform::new(
                Quaternion::exp(&Vector3::new(0.4, -1.0, 0.6)).to_matrix(),
                Vector3::new(1.0, -2.0, 0.5),
            ),
            Transform::new(
                Quaternion::exp(&Vector3::new(-2.0, 0.3, 0.9)).to_matrix(),
                Vector3::new(0.2, 0.7, -1.5),
            ),
        )
    }

    fn velocity() -> Motion<f64> {
        Motion::from_array([0.3, -1.0, 0.7, 2.0, 0.1, -0.4])
    }

    #[test]
    fn inverse_undoes_points_motions_and_forces() {
        let (X, _) = poses();
        let (V, F) = (
            velocity(),
            Force::from_array([1.3, 0.2, -0.6, -1.0, 0.9, 0.5]),
        );
        assert_relative_eq!(
            (X * X.inverse()).rotation,
            Matrix3::identity(),
            epsilon = ROUNDING
        );
        assert_relative_eq!(
            X.inverse().point(&X.point(&V.linear)),
            V.linear,
            epsilon = 10.0 * ROUNDING
        );
        assert_relative_eq!(
            X.motion_inverse(&X.motion(&V)).linear,
            V.linear,
            epsilon = 10.0 * ROUNDING
        );
        assert_relative_eq!(
            X.inverse().motion(&X.motion(&V)).linear,
            V.linear,
            epsilon = 10.0 * ROUNDING
        );
        assert_relative_eq!(
            X.force_inverse(&X.force(&F)).angular,
            F.angular,
            epsilon = 10.0 * ROUNDING
        );
    }

    #[test]
    fn composition_maps_as_one_after_the_other() {
        let (X_AB, X_BC) = poses();
        let V = velocity();
        let (direct, stepwise) = ((X_AB * X_BC).motion(&V), X_AB.motion(&X_BC.motion(&V)));
        assert_relative_eq!(direct.linear, stepwise.linear, epsilon = 10.0 * ROUNDING);
        assert_relative_eq!(direct.angular, stepwise.angular, epsilon = 10.0 * ROUNDING);
    }

    #[test]
    fn power_does_not_depend_on_the_frame() {
        let (X, _) = poses();
        let (V, F) = (
            velocity(),
            Force::from_array([1.3, 0.2, -0.6, -1.0, 0.9, 0.5]),
        );
        assert_relative_eq!(
            X.motion(&V).power(&X.force(&F)),
            V.power(&F),
            epsilon = 1e-13
        );
    }

    // The linear part is the velocity of the point at the origin: a frame turning about a point at distance r to its
    // left.
    #[test]
    fn motion_of_an_offset_frame_equals_omega_cross_r() {
        let X_AB = Transform::from_translation(Vector3::new(2.0, 0.0, 0.0));
        let V_B = Motion::from_array([0.0, 0.0, 0.0, 0.0, 0.0, 3.0]);
        // The point of the body at A's origin is at (−2, 0, 0) from the axis: ω × r = (0, −6, 0).
        assert_eq!(X_AB.motion(&V_B).linear, Vector3::new(0.0, -6.0, 0.0));
    }

    #[test]
    fn transform_equals_its_isometry() {
        let (X, _) = poses();
        let isometry: Isometry3<f64> = X.into();
        let p = Vector3::new(0.3, -1.0, 0.7);
        assert_relative_eq!(
            (isometry * nalgebra::Point3::from(p)).coords,
            X.point(&p),
            epsilon = 10.0 * ROUNDING
        );
        assert_relative_eq!(
            Transform::from(isometry).rotation,
            X.rotation,
            epsilon = 10.0 * ROUNDING
        );
    }
}
