//! The functions of `dualbody::dynamics` on arrays: those of the table, and some more.
//!
//! | file | what it is |
//! |---|---|
//! | `table` | macros that make functions of Python of the table's entries |
//! | `tangents` | tangents of states as methods of a model |

pub(crate) mod table;
mod tangents;

use dualbody_python_table::Named;
use dualbody_python_table::prelude::*;

use table::{Entry, python_functions};

/// Functions of one area, each a function of Python.
macro_rules! areas {
    ($($area:ident: $functions:path),*) => {
        $(pub(crate) mod $area {
            use super::*;
            $functions! { python_functions }
        })*

        /// All entries.
        pub(crate) fn entries() -> impl Iterator<Item = &'static Entry> {
            [$($area::entries::ALL),*].into_iter().flatten().copied()
        }

        /// Adds all functions to the module.
        pub(crate) fn add_to(module: &Bound<'_, PyModule>) -> PyResult<()> {
            $($area::add_to(module)?;)*
            Ok(())
        }
    };
}
areas! {
    forces: dualbody_python_table::dynamics_functions,
    frames: dualbody_python_table::frame_functions,
    momenta: dualbody_python_table::momentum_functions,
    base: dualbody_python_table::base_functions,
    values: crate::dynamics::functions_of_numbers
}

/// Functions without derivatives: what dual numbers are inside already.
macro_rules! functions_of_numbers {
    ($with:ident) => { $with! {
        /// Derivative of a configuration in tangent directions, (..., nq, nv): of integrate(q, dv) in dv at zero.
        _integrate_jacobian(q) -> |m| shape![m.nq(), m.nv()], |m, _, x, out| write_matrix(&m.integrate_jacobian(x[0]), out);

        /// Tangent vector of a change of a configuration's coordinates, (..., nv, nq): the derivative of difference(q, q1) in q1 at q.
        _difference_jacobian(q) -> |m| shape![m.nv(), m.nq()], |m, _, x, out| write_matrix(&m.difference_jacobian(x[0]), out);

        /// Second derivatives of tau in (q, v, a), tangent: (..., nv, 3 nv, 3 nv). q (..., nq), v and a (..., nv).
        inverse_dynamics_second_derivatives(q, v, a) -> |m| shape![m.nv(), 3 * m.nv(), 3 * m.nv()], |m, _, x, out| {
            write_all(&d::inverse_dynamics_second_derivatives(m, x[0], x[1], x[2]), out);
        };
    } };
}
use functions_of_numbers;

use crate::prelude::*;

/// The frame, representation or other item that an argument names.
pub(crate) fn named<N: Named>(model: &Model, name: &str) -> PyResult<N> {
    N::find(model, name).or_raise()
}

/// Raises a ValueError that names the joints that nothing resists, if the mass matrix is singular.
#[pyfunction]
pub(crate) fn check_mass_matrix(model: &Bound<'_, PyModel>) -> PyResult<()> {
    model.get().model.check_mass_matrix().or_raise()
}
