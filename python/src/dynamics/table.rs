//! Functions of Python from functions on one row.

use pyo3::prelude::*;

use crate::arrays::{Argument, Array, Work, map_rows};
use crate::model::PyModel;

/// Width of an argument of a name: nq or nv.
pub(crate) fn width<'a>(sizes: &'a [usize; 2], name: &str) -> &'a [usize] {
    match name {
        "q" | "q0" | "q1" => &sizes[..1],
        _ => &sizes[1..],
    }
}

/// Calls a function of rows on the arguments of a function of Python.
pub(crate) fn call<'py>(
    model: &Bound<'py, PyModel>,
    arguments: &[Argument<'_, 'py>],
    tail: &[usize],
    out: Option<&Bound<'py, PyAny>>,
    work: Work<'_>,
) -> PyResult<Array<'py>> {
    let this = model.get();
    let py = model.py();
    map_rows(py, (&this.model, this.id), arguments, tail, out, work)
}

/// Functions of the model, vectors and things by name:
/// `name(vectors; keyword: kind = "default") -> shape of a row, |model, memory, row, keywords, out| …`.
macro_rules! functions {
    ($($(#[$doc:meta])* $name:ident($($x:ident),* $(; $($key:ident: $kind:ty $(= $default:tt)?),+)?) -> $tail:expr, $one:expr;)*) => { $(
        $(#[$doc])*
        #[pyfunction]
        #[pyo3(signature = (model, $($x,)* $($($key $(= $default)?,)+)? *, out=None))]
        pub(crate) fn $name<'py>(
            model: &Bound<'py, crate::model::PyModel>,
            $($x: &Bound<'py, PyAny>,)*
            $($($key: &str,)+)?
            out: Option<&Bound<'py, PyAny>>,
        ) -> PyResult<crate::arrays::Array<'py>> {
            let m = &*model.get().model;
            $($(let $key = <$kind as crate::dynamics::Named>::find(m, $key)?;)+)?
            let tail: fn(&dualbody::Model) -> Vec<usize> = $tail;
            let one: fn(&dualbody::Model, &mut crate::scratch::Memory, &[&[f64]], $($($kind,)+)? &mut [f64]) = $one;
            let work = crate::arrays::Work {
                one: &|memory, x, out| one(m, memory, x, $($($key,)+)? out),
                wide: None,
            };
            let sizes = [m.nq(), m.nv()];
            let arguments = [$(crate::arrays::argument(stringify!($x), $x, crate::dynamics::table::width(&sizes, stringify!($x)))),*];
            crate::dynamics::table::call(model, &arguments, &tail(m), out, work)
        }
    )* };
}
pub(crate) use functions;
