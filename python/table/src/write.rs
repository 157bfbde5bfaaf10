//! Results as entries of an array.

use dualbody::Scalar;
use dualbody::contact::PointState;
use dualbody::spatial::{Force, Motion, Transform};
use nalgebra::{DMatrix, Vector3};

/// Numbers of a point of contact: position, velocity, normal, depth.
pub const POINT: usize = 10;

/// Writes a matrix row by row.
pub fn write_matrix<T: nalgebra::Scalar + Copy>(m: &DMatrix<T>, out: &mut [T]) {
    let columns = m.ncols();
    for (j, column) in m.column_iter().enumerate() {
        for (i, &x) in column.iter().enumerate() {
            out[i * columns + j] = x;
        }
    }
}

/// Writes matrices of one shape one after the other.
pub fn write_all<'a, T: Scalar>(matrices: impl IntoIterator<Item = &'a DMatrix<T>>, out: &mut [T]) {
    let mut rest = out;
    for matrix in matrices {
        let (own, others) = rest.split_at_mut(matrix.len());
        write_matrix(matrix, own);
        rest = others;
    }
}

/// Writes a motion, [linear; angular].
pub fn write_motion<T: Scalar>(motion: &Motion<T>, out: &mut [T]) {
    out.copy_from_slice(&motion.to_array());
}

/// Writes a force, [linear; angular].
pub fn write_force<T: Scalar>(force: &Force<T>, out: &mut [T]) {
    out.copy_from_slice(&force.to_array());
}

/// Writes three numbers.
pub fn write_vector3<T: Scalar>(x: &Vector3<T>, out: &mut [T]) {
    out.copy_from_slice(x.as_slice());
}

/// Writes a pose as the matrix [[R, p], [0, 1]].
pub fn write_pose<T: Scalar>(pose: &Transform<T>, out: &mut [T]) {
    for i in 0..3 {
        for j in 0..3 {
            out[4 * i + j] = pose.rotation[(i, j)];
        }
        out[4 * i + 3] = pose.translation[i];
    }
    out[12..15].fill(T::zero());
    out[15] = T::one();
}

/// Writes a point of contact.
pub fn write_point<T: Scalar>(point: &PointState<T>, out: &mut [T]) {
    let vectors = [&point.position, &point.velocity, &point.normal];
    for (vector, out) in vectors.into_iter().zip(out.chunks_mut(3)) {
        out.copy_from_slice(vector.as_slice());
    }
    out[POINT - 1] = point.depth;
}
