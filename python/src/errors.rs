//! Errors of the library as exceptions of Python, with the same texts.

use std::any::Any;
use std::fmt::{Debug, Display};
use std::panic::{AssertUnwindSafe, catch_unwind};

use dualbody::Model;
use dualbody::error::{
    EditError, InvalidState, LoadError, RecordingError, StructureMismatch, UnknownName, WriteError,
};
use dualbody::identify::IdentifyError;
use dualbody_native::NativeError;
use dualbody_python_table::Unknown;
use pyo3::PyErr;
use pyo3::exceptions::{
    PyFileNotFoundError, PyKeyError, PyKeyboardInterrupt, PyOSError, PyTypeError, PyUserWarning,
    PyValueError,
};
use pyo3::prelude::*;

use crate::words::{for_python, snake};

/// An error that Python raises as an exception of the kind that fits.
pub(crate) trait Raise {
    fn raise(self) -> PyErr;
}

macro_rules! value_errors {
    ($($error:ty),*) => { $(impl Raise for $error { fn raise(self) -> PyErr { value_error(self) } })* };
}
value_errors!(
    InvalidState,
    StructureMismatch,
    WriteError,
    dualbody::sim::AssemblyError,
    dualbody::error::SingularMassMatrix,
    dualbody::codegen::CodeError,
    dualbody::codegen::OtherRobot,
    dualbody::scalar::traced::BrokenCondition
);

impl Raise for UnknownName {
    fn raise(self) -> PyErr {
        PyKeyError::new_err(for_python(&self.to_string()))
    }
}

impl Raise for Unknown {
    fn raise(self) -> PyErr {
        match self {
            Self::Element(unknown) => unknown.raise(),
            Self::Choice(argument, given, names) => not_a_choice(argument, &given, names),
        }
    }
}

/// Errors of which one kind is an unknown name.
macro_rules! named_errors {
    ($($error:ty),*) => { $(impl Raise for $error {
        fn raise(self) -> PyErr {
            match self {
                Self::UnknownName(unknown) => unknown.raise(),
                other => value_error(other),
            }
        }
    })* };
}
named_errors!(IdentifyError, EditError, dualbody::contact::NearestError);

impl Raise for LoadError {
    fn raise(self) -> PyErr {
        match &self {
            Self::Io { source, .. } => io_error(source.kind(), for_python(&self.to_string())),
            Self::JointChoice { source, .. } if matches!(**source, EditError::UnknownName(_)) => {
                PyKeyError::new_err(for_python(&self.to_string()))
            }
            _ => value_error(self),
        }
    }
}

impl Raise for RecordingError {
    fn raise(self) -> PyErr {
        match &self {
            Self::Io { source, .. } => io_error(source.kind(), for_python(&self.to_string())),
            _ => value_error(self),
        }
    }
}

impl Raise for NativeError {
    fn raise(self) -> PyErr {
        let text = for_python(&self.to_string());
        match self {
            Self::NoCompiler { reason, .. } => io_error(reason.kind(), text),
            Self::File(file) => io_error(file.reason.kind(), text),
            Self::Code(_) => value_error(text),
            _ => PyOSError::new_err(text),
        }
    }
}

fn io_error(kind: std::io::ErrorKind, text: String) -> PyErr {
    match kind {
        std::io::ErrorKind::NotFound => PyFileNotFoundError::new_err(text),
        _ => PyOSError::new_err(text),
    }
}

pub(crate) fn value_error(error: impl Display) -> PyErr {
    PyValueError::new_err(for_python(&error.to_string()))
}

pub(crate) fn type_error(error: impl Display) -> PyErr {
    PyTypeError::new_err(for_python(&error.to_string()))
}

/// [`value_error`] of a text with values, as of `format!`.
macro_rules! invalid {
    ($($text:tt)*) => { $crate::errors::value_error(format_args!($($text)*)) };
}
pub(crate) use invalid;

/// [`type_error`] of a text with values.
macro_rules! wrong_type {
    ($($text:tt)*) => { $crate::errors::type_error(format_args!($($text)*)) };
}
pub(crate) use wrong_type;

/// Returns a `ValueError` of a text with values.
macro_rules! refuse {
    ($($text:tt)*) => { return Err($crate::errors::value_error(format_args!($($text)*))) };
}
pub(crate) use refuse;

/// Returns a `ValueError` of a text with values unless a condition holds.
macro_rules! ensure {
    ($condition:expr, $($text:tt)*) => {
        match $condition {
            true => {}
            false => $crate::errors::refuse!($($text)*),
        }
    };
}
pub(crate) use ensure;

/// The choice that an argument names, or a `ValueError` that lists all of them.
pub(crate) fn choice<T: Copy>(argument: &str, given: &str, choices: &[(&str, T)]) -> PyResult<T> {
    let found = choices.iter().find(|(name, _)| *name == given);
    found.map(|(_, value)| *value).ok_or_else(|| {
        let names: Vec<&str> = choices.iter().map(|(name, _)| *name).collect();
        not_a_choice(argument, given, &names)
    })
}

/// [`choice`] among values, whose names are those of the variants in Python's words.
pub(crate) fn variant<T: Copy + Debug>(argument: &str, given: &str, all: &[T]) -> PyResult<T> {
    let names: Vec<String> = all.iter().map(snake).collect();
    let choices = names.iter().map(String::as_str).zip(all.iter().copied());
    choice(argument, given, &choices.collect::<Vec<_>>())
}

fn not_a_choice(argument: &str, given: &str, names: &[&str]) -> PyErr {
    let names: Vec<_> = names.iter().map(|name| format!("{name:?}")).collect();
    let (last, others) = names.split_last().map_or(("", &[][..]), |(a, b)| (a, b));
    let others = others.join(", ");
    value_error(format_args!(
        "{argument} is {given:?}, not {others} or {last}"
    ))
}

/// A `ValueError` for an array of a shape that does not fit.
pub(crate) fn shape_error(name: &str, shape: impl Debug, expected: impl Display) -> PyErr {
    value_error(format_args!(
        "{name} has the shape {shape:?}, expected {expected}"
    ))
}

/// Warns in the name of the caller, in Python's words.
pub(crate) fn warn(py: Python<'_>, text: &str) -> PyResult<()> {
    let text = for_python(text).replace('\0', " ");
    let text = std::ffi::CString::new(text).unwrap_or_default();
    PyErr::warn(py, &py.get_type::<PyUserWarning>(), &text, 1)
}

/// Adds to the error of a length of q or v what a floating base has to do with it.
#[cold]
pub(crate) fn about_base(py: Python<'_>, model: &Model, error: PyErr) -> PyErr {
    let text = error.value(py).to_string();
    let is_length = ["q", "v", "q0", "q1"]
        .iter()
        .any(|name| text.starts_with(&format!("{name} has the shape")));
    match is_length && model.has_floating_base() {
        true => value_error(format_args!(
            "{text}; the base of \"{}\" floats, which takes 7 numbers of q and 6 of v: loaded with base=\"fixed\" it stands",
            model.name()
        )),
        false => error,
    }
}

/// Turns an error of the library into an exception.
pub(crate) trait OrRaise<T> {
    fn or_raise(self) -> PyResult<T>;
}

impl<T, E: Raise> OrRaise<T> for Result<T, E> {
    fn or_raise(self) -> PyResult<T> {
        self.map_err(Raise::raise)
    }
}

/// Runs code of the library, in which a panic means that an argument is wrong: it becomes a `ValueError` with the panic's text.
pub(crate) fn guarded<R>(work: impl FnOnce() -> R) -> PyResult<R> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|panic| match message(&*panic) {
        // The crate `numpy` panics where Ctrl-C is pressed while it imports NumPy.
        text if text.starts_with("Failed to access NumPy")
            && text.contains("KeyboardInterrupt") =>
        {
            PyKeyboardInterrupt::new_err(())
        }
        text => value_error(text),
    })
}

/// [`guarded`] for what may fail by itself.
pub(crate) fn caught<R>(work: impl FnOnce() -> PyResult<R>) -> PyResult<R> {
    guarded(work).and_then(|out| out)
}

/// The text of a panic, without what the macro of an assertion adds to it.
fn message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
    let text = text.unwrap_or("the library panicked without a text");
    let own = text.strip_prefix("assertion `");
    let own = own.and_then(|own| Some(own.split_once("` failed: ")?.1));
    let own = own.map(|own| own.rsplit_once("\n  left:").map_or(own, |(own, _)| own));
    own.unwrap_or(text).to_owned()
}

/// Keeps panics from printing: their texts travel in exceptions. Only panics of this extension module are concerned.
pub(crate) fn silence_panics() {
    std::panic::set_hook(Box::new(|_| {}));
}
