//! Exponential and logarithm of SE(3): from a constant velocity to the pose after unit time, and back.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::linear::{cross, dot};
use super::{Motion, Quaternion, Transform, series};
use crate::scalar::Scalar;

/// V(φ) ρ with V the translation part of the exponential of SE(3):
/// V = 1 + (1 − cos θ)/θ² [φ] + (θ − sin θ)/θ³ [φ]² [Murray, Li, Sastry 1994, 2.36].
pub(crate) fn exp_translation<T: Scalar>(rho: &Vector3<T>, phi: &Vector3<T>) -> Vector3<T> {
    let x = dot(phi, phi);
    let first = cross(phi, rho);
    rho + first * series::versine(x) + cross(phi, &first) * series::one_minus_sinc(x)
}

/// V(φ)⁻¹ p, V as in [`exp_translation`]: V⁻¹ = 1 − ½ [φ] + (1 − (θ/2) cot(θ/2))/θ² [φ]².
pub(crate) fn log_translation<T: Scalar>(p: &Vector3<T>, phi: &Vector3<T>) -> Vector3<T> {
    let first = cross(phi, p);
    p - first * T::constant(0.5) + cross(phi, &first) * series::half_cotangent(dot(phi, phi))
}

impl<T: Scalar> Transform<T> {
    /// The pose `X_AB` after unit time with the constant body velocity `V`, starting at B = A:  exp(ρ, φ) =
    /// (exp φ, V(φ) ρ).
    ///
    /// `X_WF * Transform::exp(&V)` is the frame F displaced by the *body* displacement V, `Transform::exp(&V) * X_WF`
    /// by the *inertial* one ([`Representation`](super::Representation)).
    ///
    /// * `V` – linear part ρ in m, rotation vector φ in rad
    ///
    /// Smooth everywhere, exact at 0. No allocation.
    ///
    /// # Examples
    /// ```
    /// use dualbody::spatial::{Motion, Transform};
    /// use std::f64::consts::PI;
    ///
    /// // Forwards by π while turning left by half a turn: half a circle of radius 1, to the point 2 m to the left.
    /// let X_AB = Transform::exp(&Motion::from_array([PI, 0.0, 0.0, 0.0, 0.0, PI]));
    /// assert!((X_AB.translation.y - 2.0).abs() < 1e-15 && X_AB.translation.x.abs() < 1e-15);
    /// ```
    ///
    /// # References
    /// [Murray, Li, Sastry 1994, 2.36].
    pub fn exp(V: &Motion<T>) -> Self {
        Self::new(
            Quaternion::exp(&V.angular).to_matrix(),
            exp_translation(&V.linear, &V.angular),
        )
    }

    /// The velocity `V` with exp(V) = self and a rotation of at most π rad: the displacement from A to B. Its coordinates are equal in A and in B.
    ///
    /// `(X_WF.inverse() * X_WG).log()` is the displacement of frame F to reach G, in the axes of F: the error in inverse kinematics.
    ///
    /// Smooth except at rotations by π, where it returns one of two opposite rotation vectors. No allocation.
    ///
    /// # Examples
    /// ```
    /// use dualbody::spatial::{Motion, Transform};
    ///
    /// let V = Motion::from_array([0.1, -0.2, 0.3, 0.5, 0.0, -1.0]);
    /// assert!(((Transform::exp(&V).log() - V).linear.norm()) < 1e-15);
    /// ```
    pub fn log(&self) -> Motion<T> {
        let phi = Quaternion::from_matrix(&self.rotation).log();
        Motion::new(log_translation(&self.translation, &phi), phi)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint::JointKind;
    use crate::tests::{OTHER_ALGORITHM, ROUNDING};
    use nalgebra::Matrix4;
    use num_dual::Dual64;
    use std::f64::consts::PI;

    fn velocities() -> Vec<Motion<f64>> {
        let axis = Vector3::new(0.6, 0.0, -0.8);
        [0.0, 1e-12, 1e-5, 0.3, 0.999, 1.001, 2.5, PI - 1e-6]
            .map(|angle| Motion::new(Vector3::new(0.4, -1.3, 0.7), axis * angle))
            .to_vec()
    }

    /// The velocity as a matrix that takes homogeneous coordinates of points to their rates.
    fn twist(V: &Motion<f64>) -> Matrix4<f64> {
        let mut twist = Matrix4::zeros();
        twist
            .view_mut((0, 0), (3, 3))
            .copy_from(&V.angular.cross_matrix());
        twist.view_mut((0, 3), (3, 1)).copy_from(&V.linear);
        twist
    }

    #[test]
    fn exponential_equals_that_of_the_matrix() {
        for V in velocities() {
            let (X, expected) = (Transform::exp(&V), twist(&V).exp());
            let rotation = expected.fixed_view::<3, 3>(0, 0).into_owned();
            let translation = expected.fixed_view::<3, 1>(0, 3).into_owned();
            let error = (X.rotation - rotation)
                .amax()
                .max((X.translation - translation).amax());
            assert!(error < 10.0 * ROUNDING, "{V:?}: {error:e}");
        }
    }

    #[test]
    fn logarithm_inverts_the_exponential_and_is_the_difference_of_floating_joints() {
        for V in velocities() {
            let X = Transform::exp(&V);
            let error = X.log() - V;
            assert!(
                error.linear.amax().max(error.angular.amax()) < OTHER_ALGORITHM,
                "{V:?}: {error:?}"
            );
            let mut q0 = [0.0; 7];
            JointKind::Floating.neutral(&mut q0);
            let (mut q1, mut difference) = (q0, [0.0; 6]);
            JointKind::Floating.integrate(&q0, &V.to_array(), &mut q1);
            JointKind::Floating.difference(&q0, &q1, &mut difference);
            let error = X.log() - Motion::from_array(difference);
            assert!(
                error.linear.amax().max(error.angular.amax()) < OTHER_ALGORITHM,
                "{V:?}: {error:?}"
            );
        }
    }

    // d log(exp(t V)) / dt = V, also at t = 0.
    #[test]
    fn derivative_along_the_velocity_equals_the_velocity() {
        for V in velocities().into_iter().skip(3) {
            for t in [0.0, 1e-9, 0.5, 0.9] {
                let t = Dual64::new(t, 1.0);
                let scaled = V.to_array().map(|x| t * x);
                let log = Transform::exp(&Motion::from_array(scaled)).log().to_array();
                for (log, x) in log.into_iter().zip(V.to_array()) {
                    assert!(
                        (log.eps - x).abs() < OTHER_ALGORITHM,
                        "{V:?} at {t}: {log} for {x}"
                    );
                }
            }
        }
    }
}
