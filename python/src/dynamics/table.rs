//! Functions of Python from entries of the table.

use dualbody_python_table::{Function, Memory, Prepared, Robot, Shape, shape_of};

use crate::prelude::*;

/// Most vectors of a function.
const MOST: usize = 6;

/// A function of the table on numbers and, where it is one, on lanes.
pub(crate) struct Entry {
    pub(crate) function: Function<f64>,
    pub(crate) wide: Option<OnLanes>,
}

/// A function of rows on lanes.
pub(crate) type OnLanes = fn(&Model, &mut Memory<Wide>, &[&[Wide]], &mut [Wide]);

impl Entry {
    /// The function of numbers for names of the keywords.
    pub(crate) fn prepared(&self, model: &Model, names: &[&str]) -> PyResult<Prepared<f64>> {
        let prepare = self.function.prepare.expect("there is one on numbers");
        prepare(model, names).or_raise()
    }

    /// Calls the function on arguments of Python, of which the last may be left out.
    pub(crate) fn call<'py>(
        &self,
        (robot, id): (Robot<'_, f64>, u64),
        (vectors, option): (&[&Bound<'py, PyAny>], Option<&Bound<'py, PyAny>>),
        names: &[&str],
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Array<'py>> {
        let own = &self.function;
        let f = self.prepared(robot.model(), names)?;
        let names = own.arguments.iter().chain(&own.option).copied();
        let mut shapes = [Shape::new([]); MOST];
        let mut arguments = [Argument {
            name: "",
            value: vectors[0],
            tail: &[],
        }; MOST];
        let given = vectors.iter().copied().chain(option);
        let mut count = 0;
        for ((value, name), (shape, argument)) in
            given.zip(names).zip(shapes.iter_mut().zip(&mut arguments))
        {
            *shape = shape_of(robot, name);
            *argument = Argument {
                name,
                value,
                tail: shape,
            };
            count += 1;
        }
        let wide = self.wide.map(|wide| {
            move |memory: &mut _, x: &[&[Wide]], out: &mut [Wide]| {
                wide(robot.model(), memory, x, out)
            }
        });
        let work = Work {
            one: &|memory, x, out| f(robot, memory, x, out),
            wide: wide.as_ref().map(|wide| wide as _),
        };
        let py = vectors[0].py();
        map_rows(
            py,
            (robot.model(), id),
            &arguments[..count],
            &(own.tail)(robot),
            out,
            work,
        )
    }
}

/// Entries of an area.
macro_rules! entries_of {
    ($of:ident: $Of:ident; $($(#[$doc:meta])* $name:ident $([$mark:ident])? ($($arguments:tt)*) -> $tail:expr, $one:expr;)*) => {
        #[allow(non_upper_case_globals, reason = "the names are those of the functions")]
        pub(crate) mod entries {
            use super::*;

            $(pub(crate) static $name: Entry = Entry {
                function: dualbody_python_table::function!($of: $Of, f64; $name ($($arguments)*) -> $tail, $one),
                wide: crate::dynamics::table::on_lanes!([$($mark)?] $one),
            };)*
            pub(crate) static ALL: &[&Entry] = &[$(&$name),*];
        }
    };
}
pub(crate) use entries_of;

/// Functions of Python of the entries of an area, and the entries.
macro_rules! python_functions {
    ($of:ident: $Of:ident; $($(#[$doc:meta])* $name:ident $([$mark:ident])? ($($x:ident),* $(+ $option:ident)? $(; $($key:ident: $kind:ty $(= $default:tt)?),+)?) -> $tail:expr, $one:expr;)*) => {
        entries_of! { $of: $Of; $($name $([$mark])? ($($x),* $(+ $option)? $(; $($key: $kind $(= $default)?),+)?) -> $tail, $one;)* }

        $($(#[$doc])*
        #[pyfunction]
        #[pyo3(signature = (model, $($x,)* $($($key $(= $default)?,)+)? *, $($option=None,)? out=None))]
        pub(crate) fn $name<'py>(
            model: &Bound<'py, PyModel>,
            $($x: &Bound<'py, PyAny>,)*
            $($($key: &str,)+)?
            $($option: Option<&Bound<'py, PyAny>>,)?
            out: Option<&Bound<'py, PyAny>>,
        ) -> PyResult<crate::arrays::Array<'py>> {
            let own = model.get();
            let robot = (dualbody_python_table::Robot::Model(&own.model), own.id);
            let option = dualbody_python_table::first!($($option)? None);
            entries::$name.call(robot, (&[$($x),*], option), &[$($($key),+)?], out)
        })*

        /// Adds the functions to the module.
        pub(super) fn add_to(module: &Bound<'_, PyModule>) -> PyResult<()> {
            $(module.add_function(wrap_pyfunction!($name, module)?)?;)*
            Ok(())
        }
    };
}
pub(crate) use python_functions;

/// A function on lanes, where it is one.
macro_rules! on_lanes {
    ([] $one:expr) => {
        None
    };
    ([lanes] $one:expr) => {{
        const ONE: crate::dynamics::table::OnLanes = $one;
        Some(ONE)
    }};
}
pub(crate) use on_lanes;
