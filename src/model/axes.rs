//! Axes of joints, as the frames whose z they are.

use nalgebra::{Matrix3, Vector3};

use super::builder::JointSpec;

/// The axis of a joint that has one; z, which turns nothing, for the others.
pub(super) fn unit_axis(joint: &JointSpec) -> Vector3<f64> {
    if !joint.kind.has_axis() {
        return Vector3::z();
    }
    unit(&joint.axis)
}

/// The direction of a vector that is not zero.
pub(crate) fn unit(axis: &Vector3<f64>) -> Vector3<f64> {
    // Scaled first, so that the squares of very small or large entries neither vanish nor overflow.
    (axis / axis.amax()).normalize()
}

/// A rotation R with R ẑ = `axis` (a unit vector), without rounding for the coordinate axes.
pub(super) fn align_z(axis: &Vector3<f64>) -> Matrix3<f64> {
    if *axis == Vector3::z() {
        return Matrix3::identity();
    }
    // x̂ of the new frame: perpendicular to the axis and to the coordinate direction that is least along it.
    let least = axis.iamin();
    let x = Vector3::ith(least, 1.0).cross(axis).normalize();
    Matrix3::from_columns(&[x, axis.cross(&x), *axis])
}
