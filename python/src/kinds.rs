//! Arguments that are objects of certain classes of Python.

use pyo3::prelude::*;

use crate::errors::type_error;

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
    Err(type_error(format_args!(
        "{name} is of the type {own}, expected {all}{hint}"
    )))
}
