//! Axes of joints, as the frames whose z they are.

use nalgebra::{Matrix3, Vector3};

use super::builder::JointSpec;
use crate::joint::JointKind;

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

/// The rotation `R_LB` of the body frame of a joint in its child link, whose z is the axis (a unit vector).
pub(super) fn body_frame(kind: JointKind, axis: &Vector3<f64>) -> Matrix3<f64> {
    match kind {
        JointKind::Planar => turn_z(axis),
        _ => align_z(axis),
    }
}

/// Cosine of the angle from ẑ beyond which [`turn_z`] begins with a half turn. No usual axis is there: at it the axes of the plane jump.
const NEARLY_BACKWARD: f64 = -0.5;

/// The shortest rotation R with R ẑ = `axis` (a unit vector), after half a revolution about x where the axis points backward: x̂ and ŷ of planar joints
/// are coordinates, and follow an axis that is off by rounding. Without rounding for the coordinate axes.
fn turn_z(axis: &Vector3<f64>) -> Matrix3<f64> {
    let is_backward = axis.z < NEARLY_BACKWARD;
    let to = if is_backward { -axis } else { *axis };
    // I + [w]× + [w]× [w]× / (1 + c)  with  w = ẑ × to  and  c = ẑ · to.
    let by = 1.0 / (1.0 + to.z);
    let x = Vector3::new(1.0 - to.x * to.x * by, -to.x * to.y * by, -to.x);
    let y = Vector3::new(-to.x * to.y * by, 1.0 - to.y * to.y * by, -to.y);
    let y = if is_backward { -y } else { y };
    Matrix3::from_columns(&[x, y, *axis])
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::ROUNDING;

    #[test]
    fn frames_of_axes_map_z_to_the_axis_and_are_exact_for_coordinate_axes() {
        let axes = [
            [1., 0., 0.],
            [0., 1., 0.],
            [0., 0., 1.],
            [-1., 0., 0.],
            [0., -1., 0.],
            [0., 0., -1.],
            [0.6, 0.0, -0.8],
            [0.36, -0.48, 0.8],
        ];
        for axis in axes.map(Vector3::from) {
            for kind in [JointKind::Revolute, JointKind::Planar] {
                let r = body_frame(kind, &axis);
                assert_eq!(r * Vector3::z(), axis);
                assert!(
                    (r.transpose() * r - Matrix3::identity()).norm() < ROUNDING
                        && r.determinant() > 0.0,
                    "{axis}"
                );
                if axis.iter().all(|x| x.fract() == 0.0) {
                    assert!(r.iter().all(|x| x.fract() == 0.0), "{r}");
                }
            }
        }
    }

    #[test]
    fn axes_of_planes_follow_an_axis_that_is_off_by_rounding() {
        let noise = [[6.1e-17, 0.0], [0.0, 6.1e-17], [-6.1e-17, -6.1e-17]];
        for exact in [Vector3::x(), Vector3::y(), Vector3::z()] {
            for sign in [1.0, -1.0] {
                let exact = exact * sign;
                let frame = body_frame(JointKind::Planar, &exact);
                for [first, second] in noise {
                    let off = frame * Vector3::new(first, second, 0.0);
                    let near = body_frame(JointKind::Planar, &unit(&(exact + off)));
                    assert!((near - frame).amax() < ROUNDING, "{exact}: {near}");
                }
            }
        }
    }
}
