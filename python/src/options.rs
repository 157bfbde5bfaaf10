//! Options that are keywords in Python.

use crate::kinds::named;
use crate::prelude::*;

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
            refuse!("\"{name}\" is no option of {of}");
        }
    }
    Ok(())
}

/// The choice that a text names.
pub(crate) fn chosen<T: Copy + std::fmt::Debug>(
    argument: &'static str,
    choices: &[T],
) -> impl Fn(&Bound<'_, PyAny>) -> PyResult<T> {
    move |value| variant(argument, &value.extract::<String>()?, choices)
}

/// Reads options of the library from keywords: `read_options!(Kind, "name", keywords; option, option = field.of.it, option = field by function, …)`.
macro_rules! read_options {
    ($kind:ty, $of:literal, $given:expr; $($name:ident $(= $first:ident $(. $field:ident)*)? $(by $read:expr)?),* $(,)?) => {{
        let mut options = <$kind>::default();
        let set = |name: &str, value: &Bound<'_, PyAny>| -> PyResult<bool> {
            $(if name == stringify!($name) {
                let read = read_options!(@read value $(, $read)?)?;
                read_options!(@set options, read, $name $(= $first $(. $field)*)?);
                return Ok(true);
            })*
            Ok(false)
        };
        $crate::options::set_options($of, $given, set).map(|()| options)
    }};
    (@read $value:ident) => { $value.extract() };
    (@read $value:ident, $read:expr) => { $read($value) };
    (@set $options:ident, $read:ident, $name:ident) => { $options.$name = $read };
    (@set $options:ident, $read:ident, $name:ident = $first:ident $(. $field:ident)*) => { $options.$first $(. $field)* = $read };
}
pub(crate) use read_options;
