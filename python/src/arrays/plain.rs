//! Vectors and matrices of the library from arrays, and as arrays.

pub(crate) use dualbody_python_table::write::write_matrix;

use nalgebra::DMatrix;
use numpy::{PyArray1, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;

use super::Array;
use super::output::{empty, numbers_mut, room};
use super::rows::numbers;
use crate::errors::shape_error;

/// A vector as an array.
pub(crate) fn vector<'py>(py: Python<'py>, x: &[f64]) -> Bound<'py, PyAny> {
    PyArray1::from_slice(py, x).into_any()
}

/// A matrix as an array.
pub(crate) fn matrix<'py>(py: Python<'py>, m: &DMatrix<f64>) -> Array<'py> {
    let array = empty(py, &[m.nrows(), m.ncols()]);
    write_matrix(m, numbers_mut(&array));
    array
}

/// Matrices of a shape as an array, (batch, rows, columns).
pub(crate) fn matrices<'py, 'a>(
    py: Python<'py>,
    batch: &[usize],
    shape: [usize; 2],
    all: impl Iterator<Item = &'a DMatrix<f64>>,
) -> PyResult<Array<'py>> {
    let array = room(py, &[batch, &shape].concat())?;
    let out = numbers_mut(&array).chunks_mut((shape[0] * shape[1]).max(1));
    out.zip(all).for_each(|(out, m)| write_matrix(m, out));
    Ok(array)
}

/// Rows as an array, (batch, shape of a row).
pub(crate) fn stack<'py, 'a>(
    py: Python<'py>,
    batch: &[usize],
    tail: &[usize],
    rows: impl Iterator<Item = &'a [f64]>,
) -> Array<'py> {
    let array = empty(py, &[batch, tail].concat());
    let width: usize = tail.iter().product();
    let out = numbers_mut(&array).chunks_mut(width.max(1));
    out.zip(rows)
        .for_each(|(out, row)| out.copy_from_slice(row));
    array
}

/// A matrix from an array with two axes.
pub(crate) fn read_matrix(name: &'static str, value: &Bound<'_, PyAny>) -> PyResult<DMatrix<f64>> {
    let array = numbers(name, value)?;
    let &[rows, columns] = array.shape() else {
        return Err(shape_error(name, array.shape(), "a matrix"));
    };
    // SAFETY: as in `Rows::as_slice`; the numbers are copied at once.
    let numbers = unsafe { array.as_slice().unwrap_or(&[]) };
    Ok(DMatrix::from_row_slice(rows, columns, numbers))
}

/// [`read_matrix`] of a known shape.
pub(crate) fn read_matrix_of(
    name: &'static str,
    value: &Bound<'_, PyAny>,
    shape: (usize, usize),
) -> PyResult<DMatrix<f64>> {
    match read_matrix(name, value)? {
        matrix if matrix.shape() == shape => Ok(matrix),
        other => Err(shape_error(name, other.shape(), format_args!("{shape:?}"))),
    }
}

/// A vector of a known length, or of any.
pub(crate) fn read_vector(
    name: &'static str,
    value: &Bound<'_, PyAny>,
    length: Option<usize>,
) -> PyResult<Vec<f64>> {
    let array = numbers(name, value)?;
    let shape = array.shape();
    if shape.len() != 1 || length.is_some_and(|length| shape[0] != length) {
        let expected = length.map_or("n".to_owned(), |length| length.to_string());
        return Err(shape_error(name, shape, format_args!("({expected},)")));
    }
    // SAFETY: as in `Rows::as_slice`; the numbers are copied at once.
    Ok(unsafe { array.as_slice().unwrap_or(&[]) }.to_vec())
}

/// An attribute that is a vector of N numbers.
pub(crate) fn read_numbers<const N: usize>(
    name: &'static str,
    of: &Bound<'_, PyAny>,
) -> PyResult<[f64; N]> {
    let all = read_vector(name, &of.getattr(name)?, Some(N))?;
    Ok(std::array::from_fn(|k| all[k]))
}
