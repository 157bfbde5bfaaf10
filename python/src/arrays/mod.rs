//! Arrays of numbers: shapes, batches, results.
//!
//! A vector argument of length n has the shape (…, n); what stands before n is the batch. Arguments without a batch are used for all of it.

mod map;
mod output;
mod plain;
mod rows;

use numpy::PyArrayDyn;
use pyo3::Bound;

pub(crate) use map::{WIDTH, Wide, Work, in_rows, map_plain, map_rows, map_views, with_memory};
pub(crate) use output::{checked_output, empty, numbers_mut, room};
pub(crate) use plain::{
    matrices, matrix, read_matrix, read_matrix_of, read_numbers, read_vector, stack, vector,
    write_matrix,
};
pub(crate) use rows::{Argument, Rows, View, argument, common_batch, numbers};

pub(crate) type Array<'py> = Bound<'py, PyArrayDyn<f64>>;
