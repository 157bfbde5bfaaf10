//! Arguments that are whole numbers, attributes, objects of certain classes of Python.

use pyo3::exceptions::{PyOverflowError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::PyType;

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

/// Checks that an argument is of one of some classes of a module; a `TypeError` names the argument, its type and the expected classes.
///
/// * `module` – module of the package that has the classes
/// * `hint` – how to make what is taken
pub(crate) fn check_kind(
    name: impl std::fmt::Display,
    value: &Bound<'_, PyAny>,
    module: &str,
    classes: &[&str],
    hint: &str,
) -> PyResult<()> {
    let module = value.py().import(format!("dualbody.{module}"))?;
    for class in classes {
        if value.is_instance(&module.getattr(*class)?)? {
            return Ok(());
        }
    }
    let (last, others) = classes.split_last().unwrap_or((&"", &[]));
    let all = match others {
        [] => (*last).to_owned(),
        _ => format!("{} or {last}", others.join(", ")),
    };
    let own = value.get_type().name()?;
    Err(wrong_type!(
        "{name} is of the type {own}, expected {all}{hint}"
    ))
}

/// Name of the class of the package that an object is of, by itself or by inheritance.
pub(crate) fn kind_of(value: &Bound<'_, PyAny>) -> PyResult<String> {
    let own = value.get_type();
    for class in own.mro() {
        let class = class.cast_into::<PyType>()?;
        if class.module()?.to_string().starts_with("dualbody.") {
            return Ok(class.name()?.to_string());
        }
    }
    Ok(own.name()?.to_string())
}

/// A struct of the library from an object with attributes of the same names: `fields!(value => Rigid { friction, restitution: of_it })`.
macro_rules! fields {
    ($value:expr => $kind:ident { $($field:ident $(: $given:expr)?),* $(,)? }) => {
        $kind { $($field: $crate::kinds::fields!(@read $value, $field $(, $given)?)),* }
    };
    (@read $value:expr, $field:ident) => { $value.getattr(stringify!($field))?.extract()? };
    (@read $value:expr, $field:ident, $given:expr) => { $given };
}
pub(crate) use fields;
