//! Arrays of numbers: shapes, batches, results.
//!
//! A vector argument of length n has the shape (…, n); what stands before n is the batch. Arguments without a batch are used for all of it.

mod map;
mod output;
mod plain;
mod rows;

use numpy::{PyArray1, PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;

use crate::errors::guarded;

pub(crate) use map::{WIDTH, Wide, Work, in_rows, map_plain, map_rows, map_views, with_memory};
pub(crate) use output::{checked_output, empty, numbers_mut, room};
pub(crate) use plain::{
    matrices, matrix, read_matrix, read_matrix_of, read_numbers, read_vector, stack, vector,
    write_matrix,
};
pub(crate) use rows::{Argument, Rows, View, argument, common_batch, numbers};

pub(crate) type Array<'py> = Bound<'py, PyArrayDyn<f64>>;

/// Finds NumPy's functions, where the program has imported NumPy already. Else the first array finds them, which Ctrl-C can interrupt.
pub(crate) fn find_numpy(py: Python<'_>) -> PyResult<()> {
    match py.import("sys")?.getattr("modules")?.contains("numpy")? {
        true => guarded(|| drop(PyArray1::<f64>::zeros(py, 0, false).readonly())),
        false => Ok(()),
    }
}
