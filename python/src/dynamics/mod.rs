//! The functions of `dualbody::dynamics` on arrays: those of the table, and some more.
//!
//! | file | what it is |
//! |---|---|
//! | `table` | macros that make functions of Python of the table's entries |

pub(crate) mod table;

use dualbody_python_table::Named;
use dualbody_python_table::prelude::*;

use table::{Entry, entries_of, python_functions};

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
    ($with:ident) => { $with! { model: Model;
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
use frames::{_deviation, difference, integrate};
use values::{_difference_jacobian, _integrate_jacobian};

/// The frame, representation or other item that an argument names.
pub(crate) fn named<N: Named>(model: &Model, name: &str) -> PyResult<N> {
    N::find(model, name).or_raise()
}

/// Raises a ValueError that names the joints that nothing resists, if the mass matrix is singular.
#[pyfunction]
pub(crate) fn check_mass_matrix(model: &Bound<'_, PyModel>) -> PyResult<()> {
    model.get().model.check_mass_matrix().or_raise()
}

methods! { PyModel {
    /// Configuration q ⊕ dv, moved by a tangent vector (velocity times time): (..., nq). q (..., nq), dv (..., nv).
    ///
    /// It differs from q + dv for quaternions: dv contains rotations about body axes, rad, and translations of a floating base along them, m.
    fn integrate(this: &Bound<'py, Self>, q, dv) -> PyResult<Array<'py>> { integrate(this, q, dv, None) }

    /// Tangent vector q1 ⊖ q0 from q0 to q1, in body axes at q0: (..., nv). q0 and q1 (..., nq). Rotations take the shorter way.
    fn difference(this: &Bound<'py, Self>, q0, q1) -> PyResult<Array<'py>> { difference(this, q0, q1, None) }

    /// Derivative of a configuration in tangent directions, (..., nq, nv): of integrate(q, dv) in dv at zero, so that the rate of q is J v.
    fn integrate_jacobian(this: &Bound<'py, Self>, q) -> PyResult<Array<'py>> { _integrate_jacobian(this, q, None) }

    /// Tangent vector of a change of a configuration's coordinates, (..., nv, nq): the derivative of difference(q, q1) in q1 at q.
    fn difference_jacobian(this: &Bound<'py, Self>, q) -> PyResult<Array<'py>> { _difference_jacobian(this, q, None) }

    /// Deviation (difference(q0, q), v - v0) of a state from another, (..., 2 nv): the argument of a linear controller that is designed at the reference.
    fn deviation(this: &Bound<'py, Self>, q, v, q0, v0) -> PyResult<Array<'py>> { _deviation(this, q, v, q0, v0, None) }
} }
