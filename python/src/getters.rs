//! Attributes of classes, one a line.

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
