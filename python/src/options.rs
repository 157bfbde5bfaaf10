//! Options that are keywords in Python.

use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::counts::named;
use crate::errors::value_error;

/// Sets every option that was given; a `ValueError` names one that is none.
///
/// * `of` – what has the options, for the error
/// * `set` – sets the option of a name, and returns whether there is one
pub(crate) fn set_options(
    of: &str,
    given: &Bound<'_, PyDict>,
    mut set: impl FnMut(&str, &Bound<'_, PyAny>) -> PyResult<bool>,
) -> PyResult<()> {
    for (name, value) in given {
        let name: String = name.extract()?;
        if value.is_none() {
            continue; // as if it were left out
        }
        let known = set(&name, &value).map_err(|error| named(&name, &value, error))?;
        if !known {
            return Err(value_error(format_args!("\"{name}\" is no option of {of}")));
        }
    }
    Ok(())
}
