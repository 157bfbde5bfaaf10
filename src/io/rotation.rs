//! Rotations as description files write them.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion};

use crate::scalar::MapEach;

/// Rotation by roll, pitch and yaw about fixed axes:  R = Rz(yaw) Ry(pitch) Rx(roll).
pub(super) fn rotation_from_rpy([roll, pitch, yaw]: [f64; 3]) -> Matrix3<f64> {
    let ((sr, cr), (sp, cp), (sy, cy)) = (roll.sin_cos(), pitch.sin_cos(), yaw.sin_cos());
    Matrix3::new(
        cy * cp,
        cy * sp * sr - sy * cr,
        cy * sp * cr + sy * sr,
        sy * cp,
        sy * sp * sr + cy * cr,
        sy * sp * cr - cy * sr,
        -sp,
        cp * sr,
        cp * cr,
    )
}

/// The rotation of a quaternion of any norm but zero.
pub(super) fn rotation_from_quaternion(xyzw: [f64; 4]) -> Option<Matrix3<f64>> {
    // Scaled first, so that no square vanishes or overflows.
    let largest = xyzw.iter().fold(0.0_f64, |max, x| max.max(x.abs()));
    if largest == 0.0 {
        return None;
    }
    let [x, y, z, w] = xyzw.map_each(|x| x / largest);
    let rotation = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
    Some(*rotation.to_rotation_matrix().matrix())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spatial::roll_pitch_yaw;
    use crate::tests::ROUNDING;
    use nalgebra::Rotation3;

    #[test]
    fn angles_of_a_quaternion_equal_its_rotation_even_when_pitch_is_a_right_angle() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let upright = [0.0, half, 0.0, half];
        for xyzw in [
            [0.1, -0.4, 0.3, 0.9],
            [2e200, -1e200, 0.0, 1e200],
            upright,
            [0.5, 0.5, -0.5, 0.5],
            [0.0, half + 1e-9, 0.0, half],
            [0.3, 0.639, -0.302, 0.64],
        ] {
            let [r, p, y] = roll_pitch_yaw(&rotation_from_quaternion(xyzw).unwrap());
            let largest = xyzw.iter().fold(0.0_f64, |max, x| max.max(x.abs()));
            let [qx, qy, qz, qw] = xyzw.map(|x| x / largest);
            let expected = UnitQuaternion::new_normalize(Quaternion::new(qw, qx, qy, qz));
            let error = Rotation3::from_euler_angles(r, p, y).matrix()
                - expected.to_rotation_matrix().matrix();
            assert!(error.amax() < ROUNDING * 4.0, "{xyzw:?}: {error}");
        }
        assert_eq!(rotation_from_quaternion([0.0; 4]), None);
    }
}
