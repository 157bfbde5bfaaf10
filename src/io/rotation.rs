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
