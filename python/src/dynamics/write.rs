//! Results as numbers of an array.

use dualbody::spatial::{Force, Motion, Transform};
use nalgebra::{DMatrix, Vector3};

use crate::arrays::write_matrix;

pub(super) fn write_motion(motion: &Motion<f64>, out: &mut [f64]) {
    out.copy_from_slice(&motion.to_array());
}

pub(super) fn write_force(force: &Force<f64>, out: &mut [f64]) {
    out.copy_from_slice(&force.to_array());
}

pub(super) fn write_vector3(x: &Vector3<f64>, out: &mut [f64]) {
    out.copy_from_slice(x.as_slice());
}

/// Writes a pose as the matrix [[R, p], [0, 1]].
pub(crate) fn write_pose(pose: &Transform<f64>, out: &mut [f64]) {
    for i in 0..3 {
        for j in 0..3 {
            out[4 * i + j] = pose.rotation[(i, j)];
        }
        out[4 * i + 3] = pose.translation[i];
    }
    out[12..16].copy_from_slice(&[0.0, 0.0, 0.0, 1.0]);
}

/// Writes matrices one after the other.
pub(super) fn write_all<const N: usize>(matrices: [&DMatrix<f64>; N], out: &mut [f64]) {
    let mut rest = out;
    for matrix in matrices {
        let (own, others) = rest.split_at_mut(matrix.len());
        write_matrix(matrix, own);
        rest = others;
    }
}
