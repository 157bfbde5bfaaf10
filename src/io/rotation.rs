//! Rotations as description files write them.

use nalgebra::Matrix3;

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

/// The angles with R = Rz(yaw) Ry(pitch) Rx(roll).
///
/// The roll is that of Rz(yaw)ᵀ R, so that the three agree where pitch = ±π/2 leaves roll and yaw open.
pub(super) fn roll_pitch_yaw(r: &Matrix3<f64>) -> [f64; 3] {
    let yaw = r[(1, 0)].atan2(r[(0, 0)]);
    let pitch = (-r[(2, 0)]).atan2(r[(0, 0)].hypot(r[(1, 0)]));
    let (sin, cos) = yaw.sin_cos();
    let roll = (sin * r[(0, 2)] - cos * r[(1, 2)]).atan2(cos * r[(1, 1)] - sin * r[(0, 1)]);
    [roll, pitch, yaw]
}
