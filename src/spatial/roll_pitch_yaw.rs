//! Rotations by roll, pitch and yaw, as in description files.

use nalgebra::Matrix3;

use super::Quaternion;
use crate::scalar::Scalar;

impl<T: Scalar> Quaternion<T> {
    /// The rotation by roll, pitch and yaw (rad) about the fixed axes x, y and z, in this order:
    /// R = Rz(yaw) Ry(pitch) Rx(roll), as in URDF and SDF.
    ///
    /// # Examples
    /// ```
    /// use dualbody::spatial::Quaternion;
    ///
    /// let angles: [f64; 3] = [0.3, -0.2, 2.0];
    /// let back = Quaternion::from_roll_pitch_yaw(angles).to_roll_pitch_yaw();
    /// assert!((0..3).all(|k| (angles[k] - back[k]).abs() < 1e-14));
    /// ```
    pub fn from_roll_pitch_yaw([roll, pitch, yaw]: [T; 3]) -> Self {
        let about = |angle: T, axis: usize| {
            let (sin, cos) = (angle * 0.5).sin_cos();
            let mut q = [cos, T::zero(), T::zero(), T::zero()];
            q[1 + axis] = sin;
            Self::from_slice(&q)
        };
        about(yaw, 2) * about(pitch, 1) * about(roll, 0)
    }

    /// Roll, pitch and yaw (rad) of the rotation, with the pitch in ±π/2 and the others in ±π: the inverse of
    /// [`from_roll_pitch_yaw`](Self::from_roll_pitch_yaw).
    ///
    /// # Limitations
    /// At a pitch of ±π/2 only the sum or the difference of roll and yaw is defined. The three angles still give the rotation, but are discontinuous
    /// functions of it without a finite derivative.
    pub fn to_roll_pitch_yaw(&self) -> [T; 3] {
        roll_pitch_yaw(&self.to_matrix())
    }
}

/// Roll, pitch and yaw (rad) of a rotation R = Rz(yaw) Ry(pitch) Rx(roll).
///
/// The roll is that of Rz(yaw)ᵀ R, so that the three agree where a pitch of ±π/2 leaves roll and yaw open.
pub(crate) fn roll_pitch_yaw<T: Scalar>(r: &Matrix3<T>) -> [T; 3] {
    let yaw = r[(1, 0)].atan2(r[(0, 0)]);
    let (sin, cos) = yaw.sin_cos();
    // Rz(yaw)ᵀ R = Ry(pitch) Rx(roll): first column (cos pitch, 0, −sin pitch), second row (0, cos roll, −sin roll).
    let pitch = (-r[(2, 0)]).atan2(cos * r[(0, 0)] + sin * r[(1, 0)]);
    let roll = (sin * r[(0, 2)] - cos * r[(1, 2)]).atan2(cos * r[(1, 1)] - sin * r[(0, 1)]);
    [roll, pitch, yaw]
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Rotation3, Vector3};
    use std::f64::consts::FRAC_PI_2;

    const ANGLES: [[f64; 3]; 5] = [
        [0.0, 0.0, 0.0],
        [0.3, -0.2, 2.0],
        [-3.0, 1.5, -3.1],
        [0.4, FRAC_PI_2, 0.7],
        [2.0, -FRAC_PI_2, -1.0],
    ];

    #[test]
    fn rotation_by_three_angles_equals_that_of_nalgebra() {
        for rpy in ANGLES {
            let own = Quaternion::from_roll_pitch_yaw(rpy).to_matrix();
            let expected = Rotation3::from_euler_angles(rpy[0], rpy[1], rpy[2]);
            assert!((own - expected.matrix()).amax() < 4e-15, "{rpy:?}");
        }
    }

    #[test]
    fn angles_make_the_same_rotation_again_even_where_the_pitch_is_a_right_angle() {
        for rpy in ANGLES {
            let rotation = Quaternion::from_roll_pitch_yaw(rpy);
            let back = Quaternion::from_roll_pitch_yaw(rotation.to_roll_pitch_yaw());
            let off = (rotation.conjugate() * back).log();
            assert!(off.norm() < 1e-7, "{rpy:?}: {off}");
        }
        let [roll, pitch, yaw] = Quaternion::exp(&Vector3::new(0.0, 0.0, 3.0)).to_roll_pitch_yaw();
        assert!(roll.abs() + pitch.abs() + (yaw - 3.0).abs() < 1e-14);
    }
}
