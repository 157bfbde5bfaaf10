//! Poses: a position, and an orientation in one of five ways.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{Matrix3, Rotation3, Unit, Vector3};

use super::compiler::Compiler;
use super::entry::Entry;
use crate::error::LoadError;
use crate::io::rotation::rotation_from_quaternion;
use crate::scalar::MapEach;
use crate::spatial::Transform;

/// Length below which a vector has no direction.
const LEAST_LENGTH: f64 = 1e-14;

/// The pose of an element in its parent.
pub(super) fn pose(
    entry: &Entry<'_, '_>,
    compiler: &Compiler,
) -> Result<Transform<f64>, LoadError> {
    let position = entry.numbers::<3>("pos")?.unwrap_or_default();
    let R = orientation(entry, compiler)?.unwrap_or_else(Matrix3::identity);
    Ok(Transform::new(R, position.into()))
}

/// A pose of a position and a quaternion of other names.
pub(super) fn pose_named(
    entry: &Entry<'_, '_>,
    [position, quaternion]: [&'static str; 2],
) -> Result<Transform<f64>, LoadError> {
    let p = entry.numbers::<3>(position)?.unwrap_or_default();
    let [w, x, y, z] = (entry.numbers::<4>(quaternion)?).unwrap_or([1.0, 0.0, 0.0, 0.0]);
    let zero = || entry.malformed(quaternion, "has no direction");
    let R = rotation_from_quaternion([x, y, z, w]).ok_or_else(zero)?;
    Ok(Transform::new(R, p.into()))
}

/// The pose of a position and a quaternion in one row; `None` for a quaternion of zeros.
pub(super) fn pose_of([x, y, z, qw, qx, qy, qz]: [f64; 7]) -> Option<Transform<f64>> {
    let R = rotation_from_quaternion([qx, qy, qz, qw])?;
    Some(Transform::new(R, Vector3::new(x, y, z)))
}

/// The orientation of an element, if it states one.
pub(super) fn orientation(
    entry: &Entry<'_, '_>,
    compiler: &Compiler,
) -> Result<Option<Matrix3<f64>>, LoadError> {
    let zero = |name| entry.malformed(name, "has no direction");
    if let Some([x, y, z, angle]) = entry.numbers::<4>("axisangle")? {
        let axis = Vector3::new(x, y, z);
        let axis = direction(&axis).ok_or_else(|| zero("axisangle"))?;
        return Ok(Some(about(&axis, angle * compiler.angle)));
    }
    if let Some(numbers) = entry.numbers::<6>("xyaxes")? {
        let [x, y] = [&numbers[..3], &numbers[3..]].map_each(Vector3::from_column_slice);
        return axes(&x, &y).ok_or_else(|| zero("xyaxes")).map(Some);
    }
    if let Some(z) = entry.numbers::<3>("zaxis")? {
        let z = direction(&z.into()).ok_or_else(|| zero("zaxis"))?;
        return Ok(Some(from_z(&z)));
    }
    if let Some(angles) = entry.numbers::<3>("euler")? {
        return Ok(Some(euler(
            angles.map_each(|a| a * compiler.angle),
            compiler,
        )));
    }
    let Some([w, x, y, z]) = entry.numbers::<4>("quat")? else {
        return Ok(None);
    };
    let R = rotation_from_quaternion([x, y, z, w]);
    R.ok_or_else(|| zero("quat")).map(Some)
}

/// The rotation of Euler angles, rad: about moving axes, or about fixed ones where they are capitals.
pub(super) fn euler(angles: [f64; 3], compiler: &Compiler) -> Matrix3<f64> {
    let mut R = Matrix3::identity();
    for (axis, angle) in compiler.eulerseq.into_iter().zip(angles) {
        let unit = match axis.to_ascii_lowercase() {
            'x' => Vector3::x(),
            'y' => Vector3::y(),
            _ => Vector3::z(),
        };
        let turn = about(&unit, angle);
        R = if axis.is_ascii_lowercase() {
            R * turn
        } else {
            turn * R
        };
    }
    R
}

/// The rotation about a unit vector by an angle, rad.
pub(super) fn about(axis: &Vector3<f64>, angle: f64) -> Matrix3<f64> {
    *Rotation3::from_axis_angle(&Unit::new_unchecked(*axis), angle).matrix()
}

/// The smallest rotation that takes the z axis to a unit vector; about x if that is opposite.
pub(super) fn from_z(z: &Vector3<f64>) -> Matrix3<f64> {
    let across = Vector3::z().cross(z);
    let sine = across.norm();
    let axis = direction(&across).unwrap_or_else(Vector3::x);
    about(&axis, sine.atan2(z.z))
}

/// A vector of length one, if a vector has a direction.
pub(super) fn direction(v: &Vector3<f64>) -> Option<Vector3<f64>> {
    let largest = v.amax();
    (largest > LEAST_LENGTH).then(|| (v / largest).normalize())
}

/// The axes whose x is along the first vector and whose y is in the plane of both.
fn axes(x: &Vector3<f64>, y: &Vector3<f64>) -> Option<Matrix3<f64>> {
    let x = direction(x)?;
    let y = direction(&(y - x * x.dot(y)))?;
    Some(Matrix3::from_columns(&[x, y, x.cross(&y)]))
}
