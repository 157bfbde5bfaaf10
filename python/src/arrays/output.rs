//! Arrays for results.

use numpy::{PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;

use super::Array;
use super::rows::{Rows, of_f64};
use crate::errors::{refuse, shape_error, wrong_type};
use crate::limits::check_array;

/// A new array whose numbers are not set.
pub(crate) fn empty<'py>(py: Python<'py>, shape: &[usize]) -> Array<'py> {
    // SAFETY: the numbers are plain `f64`; who asks for the array sets them before Python sees it.
    unsafe { PyArrayDyn::new(py, shape, false) }
}

/// [`empty`] for results that may be much larger than what they are made of; a `MemoryError` if there is no room.
pub(crate) fn room<'py>(py: Python<'py>, shape: &[usize]) -> PyResult<Array<'py>> {
    check_array("results", shape)?;
    Ok(empty(py, shape))
}

/// The entries of an array that this call made or was given as output.
#[expect(clippy::mut_from_ref, reason = "NumPy's arrays are shared by nature")]
pub(crate) fn numbers_mut<'a>(array: &'a Array<'_>) -> &'a mut [f64] {
    // SAFETY: the array is in C order and aligned; it is new, or an output that does not overlap the arguments.
    unsafe { array.as_slice_mut().unwrap_or(&mut []) }
}

/// The array for a result: that of the caller, or a new one.
pub(super) fn output<'a, 'py: 'a>(
    py: Python<'py>,
    out: Option<&Bound<'py, PyAny>>,
    shape: &[usize],
    arguments: impl Iterator<Item = &'a Rows<'py>>,
) -> PyResult<Array<'py>> {
    let Some(out) = out else {
        return room(py, shape);
    };
    let array = checked_output("out", out, shape)?;
    let range = |numbers: &[f64]| numbers.as_ptr_range();
    let own = range(numbers_mut(&array));
    for argument in arguments {
        let other = range(argument.as_slice());
        if own.start < other.end && other.start < own.end {
            refuse!("out overlaps an argument");
        }
    }
    Ok(array)
}

/// An array that a result can be written to.
pub(crate) fn checked_output<'py>(
    name: &str,
    out: &Bound<'py, PyAny>,
    shape: &[usize],
) -> PyResult<Array<'py>> {
    let array =
        of_f64(out).ok_or_else(|| wrong_type!("{name} is not an array of numpy.float64"))?;
    if array.shape() != shape {
        return Err(shape_error(name, array.shape(), format_args!("{shape:?}")));
    }
    // SAFETY: the pointer is that of a living array.
    let flags = unsafe { (*array.as_array_ptr()).fields.flags };
    let writeable = flags & numpy::npyffi::NPY_ARRAY_WRITEABLE != 0;
    if !(array.is_c_contiguous() && array.is_aligned() && writeable) {
        refuse!("{name} is not a writeable array in C order");
    }
    Ok(array.clone())
}
