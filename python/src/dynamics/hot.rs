//! Hot functions, on one state and on the lanes of a batch.

use dualbody::dynamics::{self as d, AbaScratch, CrbaScratch};
use dualbody::{Model, Over};
use pyo3::prelude::*;

use super::table::{call, width};
use crate::arrays::{Argument, Array, Work, argument};
use crate::model::PyModel;
use crate::scratch::Of;

pub(crate) fn rnea<T: Over<f64>>(model: &Model, memory: &mut Of<T>, x: &[&[T]], out: &mut [T]) {
    memory.read_external(x.get(3).copied().unwrap_or(&[]));
    let (external, scratch) = (&memory.external, &mut memory.rnea);
    d::inverse_dynamics_into(model, x[0], x[1], x[2], external, scratch, out);
}

fn bias<T: Over<f64>>(model: &Model, memory: &mut Of<T>, x: &[&[T]], out: &mut [T]) {
    memory.read_external(x.get(2).copied().unwrap_or(&[]));
    d::bias_forces_into(model, x[0], x[1], &memory.external, &mut memory.rnea, out);
}

fn gravity<T: Over<f64>>(model: &Model, memory: &mut Of<T>, x: &[&[T]], out: &mut [T]) {
    d::gravity_forces_into(model, x[0], &mut memory.rnea, out);
}

pub(crate) fn aba<T: Over<f64>>(model: &Model, memory: &mut Of<T>, x: &[&[T]], out: &mut [T]) {
    memory.read_external(x.get(3).copied().unwrap_or(&[]));
    let scratch = memory.aba.get_or_insert_with(|| AbaScratch::new(model));
    d::forward_dynamics_into(model, x[0], x[1], x[2], &memory.external, scratch, out);
}

fn crba<T: Over<f64>>(model: &Model, memory: &mut Of<T>, x: &[&[T]], out: &mut [T]) {
    let scratch = memory.crba.get_or_insert_with(|| CrbaScratch::new(model));
    d::mass_matrix_into(model, x[0], scratch, &mut memory.square);
    // Symmetric: columns are rows.
    out.copy_from_slice(memory.square.as_slice());
}

/// A function on both scalars.
macro_rules! on_both {
    ($model:expr, $f:ident) => {
        $crate::arrays::Work {
            one: &|memory, x, out| $f($model, &mut memory.one, x, out),
            wide: Some(&|memory, x, out| $f($model, &mut memory.wide, x, out)),
        }
    };
}
pub(crate) use on_both;

/// Functions of the model and vectors: `name(vectors) -> [sizes of a row], function on rows`.
macro_rules! hot_functions {
    ($($(#[$doc:meta])* $name:ident($($x:ident),*) -> [$($size:ident),*], $f:ident;)*) => { $(
        $(#[$doc])*
        #[pyfunction]
        #[pyo3(signature = (model, $($x,)* *, out=None))]
        pub(crate) fn $name<'py>(
            model: &Bound<'py, PyModel>,
            $($x: &Bound<'py, PyAny>,)*
            out: Option<&Bound<'py, PyAny>>,
        ) -> PyResult<Array<'py>> {
            let m = &*model.get().model;
            let sizes = [m.nq(), m.nv()];
            let arguments = [$(argument(stringify!($x), $x, width(&sizes, stringify!($x)))),*];
            call(model, &arguments, &[$(m.$size()),*], out, on_both!(m, $f))
        }
    )* };
}

/// Functions of the model, vectors and forces on the bodies that may be left out; a row is one of joint forces or accelerations.
macro_rules! forced_functions {
    ($($(#[$doc:meta])* $name:ident($($x:ident),*), $f:ident;)*) => { $(
        $(#[$doc])*
        #[pyfunction]
        #[pyo3(signature = (model, $($x,)* *, external=None, out=None))]
        pub(crate) fn $name<'py>(
            model: &Bound<'py, PyModel>,
            $($x: &Bound<'py, PyAny>,)*
            external: Option<&Bound<'py, PyAny>>,
            out: Option<&Bound<'py, PyAny>>,
        ) -> PyResult<Array<'py>> {
            let m = &*model.get().model;
            let sizes = [m.nq(), m.nv()];
            let arguments = [$(argument(stringify!($x), $x, width(&sizes, stringify!($x)))),*];
            with_external(model, &arguments, external, out, on_both!(m, $f))
        }
    )* };
}

/// Calls a function whose last argument, the external forces, may be left out.
fn with_external<'a, 'py>(
    model: &Bound<'py, PyModel>,
    arguments: &[Argument<'a, 'py>],
    external: Option<&'a Bound<'py, PyAny>>,
    out: Option<&Bound<'py, PyAny>>,
    work: Work<'_>,
) -> PyResult<Array<'py>> {
    let m = &*model.get().model;
    let nv = [m.nv()];
    let Some(external) = external else {
        return call(model, arguments, &nv, out, work);
    };
    let shape = [m.n_bodies(), 6];
    let given = arguments.iter().map(|a| argument(a.name, a.value, a.tail));
    let all: Vec<_> = given
        .chain([argument("external", external, &shape)])
        .collect();
    call(model, &all, &nv, out, work)
}

forced_functions! {
    /// Joint forces that produce the accelerations ``a``:  tau = M(q) a + h(q, v) - sum J' f.
    ///
    /// q (..., nq), v and a (..., nv; rad/s, rad/s² or m/s, m/s²), external (..., n_bodies, 6): force on each body in its
    /// frame, [linear; angular] (N, N·m), see external_forces. Returns (..., nv), N·m or N. [Featherstone 2008, table 5.1]
    inverse_dynamics(q, v, a), rnea;

    /// Accelerations that the joint forces ``tau`` produce:  a = M(q)⁻¹ (tau - h(q, v) + sum J' f).
    ///
    /// q (..., nq), v (..., nv; rad/s or m/s), tau (..., nv; N·m or N), external as in inverse_dynamics. Returns (..., nv), rad/s² or m/s².
    /// A singular mass matrix is a ValueError that names the joints. [Featherstone 2008, table 7.1]
    forward_dynamics(q, v, tau), aba;

    /// h(q, v): Coriolis, centrifugal and gravity forces, (..., nv), N·m or N.
    ///
    /// q (..., nq), v (..., nv; rad/s or m/s), external as in inverse_dynamics.
    bias_forces(q, v), bias;
}

hot_functions! {
    /// Joint forces that hold the robot still against gravity, (..., nv), N·m or N. q (..., nq).
    gravity_forces(q) -> [nv], gravity;

    /// Mass matrix M(q), (..., nv, nv), rotors included. q (..., nq). [Featherstone 2008, table 6.2]
    mass_matrix(q) -> [nv, nv], crba;
}
