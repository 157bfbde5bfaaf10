//! Whole numbers: counts, indices, seeds.

use pyo3::exceptions::{PyOverflowError, PyTypeError};
use pyo3::prelude::*;

use crate::errors::{invalid, wrong_type};

/// A whole number; a `ValueError` or `TypeError` that names the argument for what is none.
pub(crate) fn whole<'py, T: FromPyObjectOwned<'py>>(
    name: &str,
    value: &Bound<'py, PyAny>,
) -> PyResult<T> {
    let found = value.extract::<T>().map_err(Into::into);
    found.map_err(|error| named(name, value, error))
}

/// The value of an attribute; errors name it.
pub(crate) fn attribute<'py, T: FromPyObjectOwned<'py>>(
    of: &Bound<'py, PyAny>,
    name: &str,
) -> PyResult<T> {
    whole(name, &of.getattr(name)?)
}

/// The error of a conversion, with the argument's name.
#[cold]
pub(crate) fn named(name: &str, value: &Bound<'_, PyAny>, error: PyErr) -> PyErr {
    let py = value.py();
    if error.is_instance_of::<PyOverflowError>(py) {
        return match value.lt(0) {
            Ok(true) => invalid!("{name} is {value}, expected no less than zero"),
            Ok(false) => invalid!("{name} is {value}, which is too large"),
            Err(_) => invalid!("{name} is {value}: a number of it is negative or too large"),
        };
    }
    match error.is_instance_of::<PyTypeError>(py) {
        true => wrong_type!("{name}: {}", error.value(py)),
        false => error,
    }
}
