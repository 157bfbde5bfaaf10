//! Arguments, row by row.

use numpy::{PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;

use super::Array;
use crate::errors::shape_error;

/// An argument with its name and the shape of one row.
pub(crate) struct Argument<'a, 'py> {
    pub(crate) name: &'static str,
    pub(crate) value: &'a Bound<'py, PyAny>,
    pub(crate) tail: &'a [usize],
}

pub(crate) fn argument<'a, 'py>(
    name: &'static str,
    value: &'a Bound<'py, PyAny>,
    tail: &'a [usize],
) -> Argument<'a, 'py> {
    Argument { name, value, tail }
}

/// An array of numbers in C order that was read from an argument.
pub(crate) struct Rows<'py> {
    pub(super) array: Array<'py>,
    /// Length of a row.
    pub(super) width: usize,
    /// Number of axes of the batch.
    pub(super) lead: usize,
}

impl<'py> Rows<'py> {
    /// Reads an argument, without a copy if it holds `float64` in C order.
    pub(crate) fn read(argument: &Argument<'_, 'py>) -> PyResult<Self> {
        let array = numbers(argument.name, argument.value)?;
        let (shape, tail) = (array.shape(), argument.tail);
        let Some(lead) = shape.len().checked_sub(tail.len()) else {
            return Err(wrong_shape(argument, shape));
        };
        if shape[lead..] != *tail {
            return Err(wrong_shape(argument, shape));
        }
        Ok(Self {
            width: tail.iter().product(),
            lead,
            array,
        })
    }

    pub(crate) fn into_array(self) -> Array<'py> {
        self.array
    }

    /// The shape of the batch.
    pub(crate) fn batch(&self) -> &[usize] {
        &self.array.shape()[..self.lead]
    }

    pub(crate) fn as_slice(&self) -> &[f64] {
        // SAFETY: the array is aligned and in C order, and alive as long as `self`. As for every function of NumPy that releases the
        // interpreter lock, it is the caller's part not to write to an argument from another thread meanwhile.
        unsafe { self.array.as_slice().unwrap_or(&[]) }
    }

    pub(super) fn view(&self) -> View<'_> {
        View {
            numbers: self.as_slice(),
            width: self.width,
            single: self.lead == 0,
        }
    }
}

/// The numbers of an argument, row by row.
#[derive(Clone, Copy)]
pub(super) struct View<'a> {
    pub(super) numbers: &'a [f64],
    pub(super) width: usize,
    pub(super) single: bool,
}

impl<'a> View<'a> {
    pub(super) fn row(&self, k: usize) -> &'a [f64] {
        let k = if self.single { 0 } else { k };
        &self.numbers[k * self.width..(k + 1) * self.width]
    }
}

fn wrong_shape(argument: &Argument<'_, '_>, shape: &[usize]) -> PyErr {
    let (name, tail) = (argument.name, argument.tail);
    let tail: Vec<String> = tail.iter().map(ToString::to_string).collect();
    shape_error(name, shape, format_args!("(…, {})", tail.join(", ")))
}

/// An array of `float64` in C order: the argument itself, or a copy.
pub(crate) fn numbers<'py>(name: &str, value: &Bound<'py, PyAny>) -> PyResult<Array<'py>> {
    if let Ok(array) = value.cast::<PyArrayDyn<f64>>()
        && array.is_c_contiguous()
        && array.is_aligned()
    {
        return Ok(array.clone());
    }
    converted(name, value)
}

static CONVERT: PyOnceLock<Py<PyAny>> = PyOnceLock::new();

#[cold]
fn converted<'py>(name: &str, value: &Bound<'py, PyAny>) -> PyResult<Array<'py>> {
    let py = value.py();
    let convert = CONVERT.import(py, "dualbody._convert", "numbers")?;
    Ok(convert
        .call1((name, value))?
        .cast_into::<PyArrayDyn<f64>>()?)
}
