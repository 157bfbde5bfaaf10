//! Arguments, row by row.

use numpy::npyffi::{NPY_TYPES, PyArray_CheckExact};
use numpy::{PyArray1, PyArrayDyn, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;

use super::Array;
use crate::errors::{guarded, refuse, shape_error};
use crate::limits::check_array;

/// An argument with its name and the shape of one row.
#[derive(Clone, Copy)]
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

    pub(crate) fn view(&self) -> View<'_> {
        View {
            numbers: self.as_slice(),
            width: self.width,
            single: self.lead == 0,
        }
    }
}

/// The entries of an argument, row by row.
#[derive(Clone, Copy)]
pub(crate) struct View<'a> {
    pub(super) numbers: &'a [f64],
    pub(super) width: usize,
    pub(super) single: bool,
}

impl<'a> View<'a> {
    /// Rows one after the other.
    pub(crate) fn of_batch(numbers: &'a [f64], width: usize) -> Self {
        Self {
            numbers,
            width,
            single: false,
        }
    }

    pub(crate) fn row(&self, k: usize) -> &'a [f64] {
        let k = if self.single { 0 } else { k };
        &self.numbers[k * self.width..(k + 1) * self.width]
    }
}

/// Checks that all arguments are of one batch, or of none.
pub(crate) fn common_batch<'a>(
    batches: impl Iterator<Item = (&'static str, &'a [usize])>,
) -> PyResult<Vec<usize>> {
    let mut known: Option<(&'static str, &[usize])> = None;
    for (name, batch) in batches.filter(|(_, batch)| !batch.is_empty()) {
        match known {
            Some((other, shape)) if shape != batch => {
                refuse!("{name} is a batch of shape {batch:?}, {other} one of shape {shape:?}");
            }
            _ => known = Some((name, batch)),
        }
    }
    Ok(known.map_or(Vec::new(), |(_, batch)| batch.to_vec()))
}

fn wrong_shape(argument: &Argument<'_, '_>, shape: &[usize]) -> PyErr {
    let (name, tail) = (argument.name, argument.tail);
    let tail: Vec<String> = tail.iter().map(ToString::to_string).collect();
    shape_error(name, shape, format_args!("(…, {})", tail.join(", ")))
}

/// An array of `float64` in C order: the argument itself, or a copy.
#[inline]
pub(crate) fn numbers<'py>(name: &str, value: &Bound<'py, PyAny>) -> PyResult<Array<'py>> {
    find_numpy(value.py())?;
    if let Some(array) = of_f64(value)
        && is_plain(array)
        && array.is_c_contiguous()
        && array.is_aligned()
    {
        return Ok(array.clone());
    }
    converted(name, value)
}

/// Finds NumPy's functions before the first array, for which a few lines of Python run that Ctrl-C may interrupt.
fn find_numpy(py: Python<'_>) -> PyResult<()> {
    static IS_FOUND: PyOnceLock<()> = PyOnceLock::new();
    let find = || guarded(|| drop(PyArray1::<f64>::zeros(py, 0, false).readonly()));
    IS_FOUND.get_or_try_init(py, find).copied()
}

/// Whether an array is of no subclass: those of masked arrays, for example, mean more than their numbers.
fn is_plain(array: &Array<'_>) -> bool {
    // SAFETY: the array is alive.
    unsafe { PyArray_CheckExact(array.py(), array.as_ptr()) != 0 }
}

/// The argument as an array of `float64` in the order of bytes of this machine. Reads what the array says of itself: to make a type of element
/// to compare with would take longer than all else that is done with an argument.
pub(super) fn of_f64<'a, 'py>(value: &'a Bound<'py, PyAny>) -> Option<&'a Array<'py>> {
    let array = value.cast::<PyUntypedArray>().ok()?;
    // SAFETY: the pointers are those of a living array and of its type of element.
    let element = unsafe { &(*(*array.as_array_ptr()).fields.descr).fields };
    let is_f64 = element.type_num == NPY_TYPES::NPY_DOUBLE as i32;
    // SAFETY: its type of element is that of the other type.
    (is_f64 && element.byteorder as u8 == b'=').then(|| unsafe { array.cast_unchecked() })
}

static CONVERT: PyOnceLock<Py<PyAny>> = PyOnceLock::new();

#[cold]
fn converted<'py>(name: &str, value: &Bound<'py, PyAny>) -> PyResult<Array<'py>> {
    let py = value.py();
    // A view that repeats one row may be larger than memory.
    if let Ok(array) = value.cast::<PyUntypedArray>() {
        check_array(format_args!("copies of {name}"), array.shape())?;
    }
    let convert = CONVERT.import(py, "dualbody._convert", "numbers")?;
    Ok(convert
        .call1((name, value))?
        .cast_into::<PyArrayDyn<f64>>()?)
}
