//! Attributes, methods and functions of Python, with their arguments as Python has them.

use pyo3::prelude::*;
use pyo3::types::PySlice;

/// Attributes of a class: `/// What it is.` `name: Type = |own| value;`, or `|own, py| value` for one that is made of objects of Python.
macro_rules! getters {
    ($class:ident { $($(#[$doc:meta])* $name:ident: $type:ty = |$own:ident $(, $py:ident)?| $value:expr;)* }) => { $(
        getters!(@one $class, [$(#[$doc])*] $name: $type = |$own $(, $py)?| $value);
    )* };
    (@one $class:ident, [$($doc:tt)*] $name:ident: $type:ty = |$own:ident| $value:expr) => {
        #[pymethods]
        impl $class {
            $($doc)*
            #[getter]
            pub(crate) fn $name(&self) -> $type {
                let $own = self;
                $value
            }
        }
    };
    (@one $class:ident, [$($doc:tt)*] $name:ident: $type:ty = |$own:ident, $py:ident| $value:expr) => {
        #[pymethods]
        impl $class {
            $($doc)*
            #[getter]
            pub(crate) fn $name<'py>(&self, $py: Python<'py>) -> $type {
                let $own = self;
                $value
            }
        }
    };
}
pub(crate) use getters;

/// Methods of a class, each with its arguments written once: `fn name(&self, q, u = None, *, count: usize = 1, **keywords) -> … { … }`.
///
/// An argument without a type is any object, and may be left out if it is `None` by default. `py: Python` and `this: &Bound<'py, Self>` are no arguments in Python.
macro_rules! methods {
    ($class:ident { $($(#[$attribute:meta])* fn $name:ident($($arguments:tt)*) $(-> $out:ty)? $body:block)* }) => { $(
        crate::python::item!([$class] [$(#[$attribute])*] $name [$(-> $out)?] $body [] [] $($arguments)*);
    )* };
}
pub(crate) use methods;

/// Functions, with arguments as those of [`methods`].
macro_rules! functions {
    ($($(#[$attribute:meta])* fn $name:ident($($arguments:tt)*) $(-> $out:ty)? $body:block)*) => { $(
        crate::python::item!([] [$(#[$attribute])*] $name [$(-> $out)?] $body [] [] $($arguments)*);
    )* };
}
pub(crate) use functions;

/// A method or function, whose arguments are read one by one: those of Python go to the signature, all of them to the arguments in Rust. A panic in it is an
/// exception.
macro_rules! item {
    ([$class:ident] [$($attribute:tt)*] $name:ident [$($out:tt)*] $body:block [$($signature:tt)*] [$($all:tt)*]) => {
        #[pymethods]
        #[allow(clippy::extra_unused_lifetimes, clippy::needless_lifetimes, reason = "all methods have the lifetime")]
        impl $class {
            $($attribute)*
            #[pyo3(signature = ($($signature)*))]
            pub(crate) fn $name<'py>($($all)*) $($out)* {
                crate::errors::caught(move || $body)
            }
        }
    };
    ([] [$($attribute:tt)*] $name:ident [$($out:tt)*] $body:block [$($signature:tt)*] [$($all:tt)*]) => {
        $($attribute)*
        #[pyfunction]
        #[pyo3(signature = ($($signature)*))]
        #[allow(clippy::extra_unused_lifetimes, clippy::needless_lifetimes, reason = "all functions have the lifetime")]
        pub(crate) fn $name<'py>($($all)*) $($out)* {
            crate::errors::caught(move || $body)
        }
    };
    ($c:tt $a:tt $n:ident $o:tt $b:block [$($s:tt)*] [$($all:tt)*] & $own:ident $(, $($rest:tt)*)?) => {
        crate::python::item!($c $a $n $o $b [$($s)*] [$($all)* & $own,] $($($rest)*)?);
    };
    ($c:tt $a:tt $n:ident $o:tt $b:block [$($s:tt)*] [$($all:tt)*] & mut $own:ident $(, $($rest:tt)*)?) => {
        crate::python::item!($c $a $n $o $b [$($s)*] [$($all)* & mut $own,] $($($rest)*)?);
    };
    ($c:tt $a:tt $n:ident $o:tt $b:block [$($s:tt)*] [$($all:tt)*] $py:ident: Python $(, $($rest:tt)*)?) => {
        crate::python::item!($c $a $n $o $b [$($s)*] [$($all)* $py: Python<'py>,] $($($rest)*)?);
    };
    ($c:tt $a:tt $n:ident $o:tt $b:block [$($s:tt)*] [$($all:tt)*] $this:ident: &Bound<'py, Self> $(, $($rest:tt)*)?) => {
        crate::python::item!($c $a $n $o $b [$($s)*] [$($all)* $this: &Bound<'py, Self>,] $($($rest)*)?);
    };
    ($c:tt $a:tt $n:ident $o:tt $b:block [$($s:tt)*] [$($all:tt)*] ** $x:ident $(, $($rest:tt)*)?) => {
        crate::python::item!($c $a $n $o $b [$($s)* ** $x,] [$($all)* $x: Option<&Bound<'py, pyo3::types::PyDict>>,] $($($rest)*)?);
    };
    ($c:tt $a:tt $n:ident $o:tt $b:block [$($s:tt)*] [$($all:tt)*] * $x:ident $(, $($rest:tt)*)?) => {
        crate::python::item!($c $a $n $o $b [$($s)* * $x,] [$($all)* $x: &Bound<'py, pyo3::types::PyTuple>,] $($($rest)*)?);
    };
    ($c:tt $a:tt $n:ident $o:tt $b:block [$($s:tt)*] [$($all:tt)*] *, $($rest:tt)*) => {
        crate::python::item!($c $a $n $o $b [$($s)* *,] [$($all)*] $($rest)*);
    };
    // As tokens: PyO3 sees only then that there is a default other than `None`.
    ($c:tt $a:tt $n:ident $o:tt $b:block [$($s:tt)*] [$($all:tt)*] $x:ident: Option<&str> = $default:tt $(, $($rest:tt)*)?) => {
        crate::python::item!($c $a $n $o $b [$($s)* $x = $default,] [$($all)* $x: Option<&str>,] $($($rest)*)?);
    };
    ($c:tt $a:tt $n:ident $o:tt $b:block [$($s:tt)*] [$($all:tt)*] $x:ident: $type:ty = $default:tt $(, $($rest:tt)*)?) => {
        crate::python::item!($c $a $n $o $b [$($s)* $x = $default,] [$($all)* $x: $type,] $($($rest)*)?);
    };
    ($c:tt $a:tt $n:ident $o:tt $b:block [$($s:tt)*] [$($all:tt)*] $x:ident: $type:ty $(, $($rest:tt)*)?) => {
        crate::python::item!($c $a $n $o $b [$($s)* $x,] [$($all)* $x: $type,] $($($rest)*)?);
    };
    ($c:tt $a:tt $n:ident $o:tt $b:block [$($s:tt)*] [$($all:tt)*] $x:ident = None $(, $($rest:tt)*)?) => {
        crate::python::item!($c $a $n $o $b [$($s)* $x = None,] [$($all)* $x: Option<&Bound<'py, PyAny>>,] $($($rest)*)?);
    };
    ($c:tt $a:tt $n:ident $o:tt $b:block [$($s:tt)*] [$($all:tt)*] $x:ident $(, $($rest:tt)*)?) => {
        crate::python::item!($c $a $n $o $b [$($s)* $x,] [$($all)* $x: &Bound<'py, PyAny>,] $($($rest)*)?);
    };
}
pub(crate) use item;

/// An object of a module of the package, which is looked up once: `of_package!(py, "_rollout", "Linearization")`.
macro_rules! of_package {
    ($py:expr, $module:literal, $name:literal) => {{
        static FOUND: pyo3::sync::PyOnceLock<Py<PyAny>> = pyo3::sync::PyOnceLock::new();
        FOUND.import($py, concat!("dualbody.", $module), $name)?
    }};
}
pub(crate) use of_package;

/// A dictionary of values by name: `dict!(py; time_step, integrator = py.None())`.
macro_rules! dict {
    ($py:expr; $($name:ident $(= $value:expr)?),* $(,)?) => {{
        let out = PyDict::new($py);
        $(out.set_item(stringify!($name), crate::python::dict!(@value $name $($value)?))?;)*
        out
    }};
    (@value $name:ident) => { $name };
    (@value $name:ident $value:expr) => { $value };
}
pub(crate) use dict;

/// The callable that makes a pickled object again, and its arguments.
pub(crate) type Recipe<'py> = PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)>;

/// A range as a slice of Python.
pub(crate) fn slice(py: Python<'_>, range: std::ops::Range<usize>) -> Bound<'_, PySlice> {
    PySlice::new(py, range.start as isize, range.end as isize, 1)
}
