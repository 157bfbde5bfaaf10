//! The functions of `dualbody::dynamics` on arrays.

use dualbody::dynamics::{
    self as d, AbaScratch, CoriolisScratch, CrbaScratch, ForwardDynamicsDerivatives,
    ForwardDynamicsDerivativesScratch, InverseDynamicsDerivatives,
    InverseDynamicsDerivativesScratch, MassMatrixInverseScratch, MomentumFrame, NamedForces,
};
use dualbody::spatial::{Force, Motion, Representation, Transform};
use dualbody::{Model, Over};
use nalgebra::{DMatrix, Vector3};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{
    Argument, Array, Work, argument, map_rows, read_matrix, read_vector, write_matrix,
};
use crate::errors::{OrRaise, value_error};
use crate::model::PyModel;
use crate::scratch::Of;

pub(crate) fn representation(name: &str) -> PyResult<Representation> {
    match name {
        "body" => Ok(Representation::Body),
        "mixed" => Ok(Representation::Mixed),
        "inertial" => Ok(Representation::Inertial),
        _ => Err(value_error(format_args!(
            "representation is \"{name}\", not \"body\", \"mixed\" or \"inertial\""
        ))),
    }
}

fn momentum_frame(name: &str) -> PyResult<MomentumFrame> {
    match name {
        "centroidal" => Ok(MomentumFrame::Centroidal),
        "world" => Ok(MomentumFrame::World),
        "base" => Ok(MomentumFrame::Base),
        _ => Err(value_error(format_args!(
            "frame is \"{name}\", not \"centroidal\", \"world\" or \"base\""
        ))),
    }
}

/// Width of an argument of a name.
fn width(model: &Model, name: &str) -> [usize; 1] {
    match name {
        "q" | "q0" | "q1" => [model.nq()],
        _ => [model.nv()],
    }
}

/// Calls a function of rows on the arguments of a function of Python.
fn call<'py>(
    model: &Bound<'py, PyModel>,
    arguments: &[Argument<'_, 'py>],
    tail: &[usize],
    out: Option<&Bound<'py, PyAny>>,
    work: Work<'_>,
) -> PyResult<Array<'py>> {
    let this = model.get();
    map_rows(
        model.py(),
        (&this.model, this.id),
        arguments,
        tail,
        out,
        work,
    )
}

/// Functions of the model and vectors: `name(arguments) -> shape of a row, |model, row, out| …`.
macro_rules! functions {
    ($($(#[$doc:meta])* $name:ident($($x:ident),*) -> $tail:expr, $one:expr;)*) => { $(
        $(#[$doc])*
        #[pyfunction]
        #[pyo3(signature = (model, $($x,)* *, out=None))]
        pub(crate) fn $name<'py>(
            model: &Bound<'py, PyModel>,
            $($x: &Bound<'py, PyAny>,)*
            out: Option<&Bound<'py, PyAny>>,
        ) -> PyResult<Array<'py>> {
            let m = &*model.get().model;
            let tail: fn(&Model) -> Vec<usize> = $tail;
            let one: fn(&Model, &[&[f64]], &mut [f64]) = $one;
            let work = Work { one: &|_, x, out| one(m, x, out), wide: None };
            call(model, &[$(argument(stringify!($x), $x, &width(m, stringify!($x)))),*], &tail(m), out, work)
        }
    )* };
}

/// Functions of the model, vectors, a frame by its name and a representation.
macro_rules! frame_functions {
    ($($(#[$doc:meta])* $name:ident($($x:ident),*) -> $tail:expr, $one:expr;)*) => { $(
        $(#[$doc])*
        #[pyfunction]
        #[pyo3(signature = (model, $($x,)* frame, representation="body", *, out=None))]
        pub(crate) fn $name<'py>(
            model: &Bound<'py, PyModel>,
            $($x: &Bound<'py, PyAny>,)*
            frame: &str,
            representation: &str,
            out: Option<&Bound<'py, PyAny>>,
        ) -> PyResult<Array<'py>> {
            let m = &*model.get().model;
            let tail: fn(&Model) -> Vec<usize> = $tail;
            let id = m.find_frame(frame).or_raise()?;
            let representation = self::representation(representation)?;
            let one: fn(&Model, &mut Of<f64>, &[&[f64]], dualbody::model::FrameId, Representation, &mut [f64]) = $one;
            let work = Work { one: &|memory, x, out| one(m, &mut memory.one, x, id, representation, out), wide: None };
            call(model, &[$(argument(stringify!($x), $x, &width(m, stringify!($x)))),*], &tail(m), out, work)
        }
    )* };
}

/// Functions of the model, vectors and a frame by its name.
macro_rules! placement_functions {
    ($($(#[$doc:meta])* $name:ident($($x:ident),*) -> $tail:expr, $one:expr;)*) => { $(
        $(#[$doc])*
        #[pyfunction]
        #[pyo3(signature = (model, $($x,)* frame, *, out=None))]
        pub(crate) fn $name<'py>(
            model: &Bound<'py, PyModel>,
            $($x: &Bound<'py, PyAny>,)*
            frame: &str,
            out: Option<&Bound<'py, PyAny>>,
        ) -> PyResult<Array<'py>> {
            let m = &*model.get().model;
            let tail: fn(&Model) -> Vec<usize> = $tail;
            let id = m.find_frame(frame).or_raise()?;
            let one: fn(&Model, &[&[f64]], dualbody::model::FrameId, &mut [f64]) = $one;
            let work = Work { one: &|_, x, out| one(m, x, id, out), wide: None };
            call(model, &[$(argument(stringify!($x), $x, &width(m, stringify!($x)))),*], &tail(m), out, work)
        }
    )* };
}

/// Functions of the model, vectors and a frame of momentum.
macro_rules! momentum_functions {
    ($($(#[$doc:meta])* $name:ident($($x:ident),*) -> $tail:expr, $one:expr;)*) => { $(
        $(#[$doc])*
        #[pyfunction]
        #[pyo3(signature = (model, $($x,)* frame="centroidal", *, out=None))]
        pub(crate) fn $name<'py>(
            model: &Bound<'py, PyModel>,
            $($x: &Bound<'py, PyAny>,)*
            frame: &str,
            out: Option<&Bound<'py, PyAny>>,
        ) -> PyResult<Array<'py>> {
            let m = &*model.get().model;
            let tail: fn(&Model) -> Vec<usize> = $tail;
            let frame = momentum_frame(frame)?;
            let one: fn(&Model, &[&[f64]], MomentumFrame, &mut [f64]) = $one;
            let work = Work { one: &|_, x, out| one(m, x, frame, out), wide: None };
            call(model, &[$(argument(stringify!($x), $x, &width(m, stringify!($x)))),*], &tail(m), out, work)
        }
    )* };
}

/// Functions of the model, vectors and a representation of the velocity of the base.
macro_rules! base_functions {
    ($($(#[$doc:meta])* $name:ident($($x:ident),*), $one:expr;)*) => { $(
        $(#[$doc])*
        #[pyfunction]
        #[pyo3(signature = (model, $($x,)* representation, *, out=None))]
        pub(crate) fn $name<'py>(
            model: &Bound<'py, PyModel>,
            $($x: &Bound<'py, PyAny>,)*
            representation: &str,
            out: Option<&Bound<'py, PyAny>>,
        ) -> PyResult<Array<'py>> {
            let m = &*model.get().model;
            let representation = self::representation(representation)?;
            let one: fn(&Model, &[&[f64]], Representation) -> nalgebra::DVector<f64> = $one;
            let work = Work {
                one: &|_, x, out| out.copy_from_slice(one(m, x, representation).as_slice()),
                wide: None,
            };
            call(model, &[$(argument(stringify!($x), $x, &width(m, stringify!($x)))),*], &[m.nv()], out, work)
        }
    )* };
}

fn write_motion(motion: &Motion<f64>, out: &mut [f64]) {
    out.copy_from_slice(&motion.to_array());
}

fn write_force(force: &Force<f64>, out: &mut [f64]) {
    out.copy_from_slice(&force.to_array());
}

fn write_vector3(x: &Vector3<f64>, out: &mut [f64]) {
    out.copy_from_slice(x.as_slice());
}

/// Writes a pose as the matrix [[R, p], [0, 1]].
pub(crate) fn write_pose(pose: &Transform<f64>, out: &mut [f64]) {
    for i in 0..3 {
        for j in 0..3 {
            out[4 * i + j] = pose.rotation[(i, j)];
        }
        out[4 * i + 3] = pose.translation[i];
    }
    out[12..16].copy_from_slice(&[0.0, 0.0, 0.0, 1.0]);
}

// Hot functions, on one state and on the lanes of a batch.

fn rnea<T: Over<f64>>(model: &Model, memory: &mut Of<T>, x: &[&[T]], out: &mut [T]) {
    memory.read_external(x.get(3).copied().unwrap_or(&[]));
    d::inverse_dynamics_into(
        model,
        x[0],
        x[1],
        x[2],
        &memory.external,
        &mut memory.rnea,
        out,
    );
}

fn bias<T: Over<f64>>(model: &Model, memory: &mut Of<T>, x: &[&[T]], out: &mut [T]) {
    memory.read_external(x.get(2).copied().unwrap_or(&[]));
    d::bias_forces_into(model, x[0], x[1], &memory.external, &mut memory.rnea, out);
}

fn gravity<T: Over<f64>>(model: &Model, memory: &mut Of<T>, x: &[&[T]], out: &mut [T]) {
    d::gravity_forces_into(model, x[0], &mut memory.rnea, out);
}

fn aba<T: Over<f64>>(model: &Model, memory: &mut Of<T>, x: &[&[T]], out: &mut [T]) {
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

macro_rules! hot {
    ($model:expr, $f:ident) => {
        Work {
            one: &|memory, x, out| $f($model, &mut memory.one, x, out),
            wide: Some(&|memory, x, out| $f($model, &mut memory.wide, x, out)),
        }
    };
}

/// Joint forces that produce the accelerations ``a``:  tau = M(q) a + h(q, v) - sum J' f.
///
/// q (..., nq), v and a (..., nv; rad/s, rad/s² or m/s, m/s²), external (..., n_bodies, 6): force on each body in its
/// frame, [linear; angular] (N, N·m), see external_forces. Returns (..., nv), N·m or N. [Featherstone 2008, table 5.1]
#[pyfunction]
#[pyo3(signature = (model, q, v, a, *, external=None, out=None))]
pub(crate) fn inverse_dynamics<'py>(
    model: &Bound<'py, PyModel>,
    q: &Bound<'py, PyAny>,
    v: &Bound<'py, PyAny>,
    a: &Bound<'py, PyAny>,
    external: Option<&Bound<'py, PyAny>>,
    out: Option<&Bound<'py, PyAny>>,
) -> PyResult<Array<'py>> {
    let m = &*model.get().model;
    let (nq, nv, forces) = ([m.nq()], [m.nv()], [m.n_bodies(), 6]);
    let arguments = [
        argument("q", q, &nq),
        argument("v", v, &nv),
        argument("a", a, &nv),
    ];
    with_external(model, arguments, external, &forces, out, hot!(m, rnea))
}

/// Accelerations that the joint forces ``tau`` produce:  a = M(q)⁻¹ (tau - h(q, v) + sum J' f).
///
/// q (..., nq), v (..., nv; rad/s or m/s), tau (..., nv; N·m or N), external as in inverse_dynamics. Returns (..., nv), rad/s² or m/s².
/// A singular mass matrix is a ValueError that names the joints. [Featherstone 2008, table 7.1]
#[pyfunction]
#[pyo3(signature = (model, q, v, tau, *, external=None, out=None))]
pub(crate) fn forward_dynamics<'py>(
    model: &Bound<'py, PyModel>,
    q: &Bound<'py, PyAny>,
    v: &Bound<'py, PyAny>,
    tau: &Bound<'py, PyAny>,
    external: Option<&Bound<'py, PyAny>>,
    out: Option<&Bound<'py, PyAny>>,
) -> PyResult<Array<'py>> {
    let m = &*model.get().model;
    let (nq, nv, forces) = ([m.nq()], [m.nv()], [m.n_bodies(), 6]);
    let arguments = [
        argument("q", q, &nq),
        argument("v", v, &nv),
        argument("tau", tau, &nv),
    ];
    with_external(model, arguments, external, &forces, out, hot!(m, aba))
}

/// h(q, v): Coriolis, centrifugal and gravity forces, (..., nv), N·m or N.
///
/// q (..., nq), v (..., nv; rad/s or m/s), external as in inverse_dynamics.
#[pyfunction]
#[pyo3(signature = (model, q, v, *, external=None, out=None))]
pub(crate) fn bias_forces<'py>(
    model: &Bound<'py, PyModel>,
    q: &Bound<'py, PyAny>,
    v: &Bound<'py, PyAny>,
    external: Option<&Bound<'py, PyAny>>,
    out: Option<&Bound<'py, PyAny>>,
) -> PyResult<Array<'py>> {
    let m = &*model.get().model;
    let (nq, nv, forces) = ([m.nq()], [m.nv()], [m.n_bodies(), 6]);
    let arguments = [argument("q", q, &nq), argument("v", v, &nv)];
    with_external(model, arguments, external, &forces, out, hot!(m, bias))
}

/// Calls a function whose last argument, the external forces, may be left out.
fn with_external<'a, 'py, const N: usize>(
    model: &Bound<'py, PyModel>,
    arguments: [Argument<'a, 'py>; N],
    external: Option<&'a Bound<'py, PyAny>>,
    shape: &'a [usize],
    out: Option<&Bound<'py, PyAny>>,
    work: Work<'_>,
) -> PyResult<Array<'py>> {
    let nv = [model.get().model.nv()];
    let Some(external) = external else {
        return call(model, &arguments, &nv, out, work);
    };
    let mut all = Vec::from(arguments);
    all.push(argument("external", external, shape));
    call(model, &all, &nv, out, work)
}

/// Joint forces that hold the robot still against gravity, (..., nv), N·m or N. q (..., nq).
#[pyfunction]
#[pyo3(signature = (model, q, *, out=None))]
pub(crate) fn gravity_forces<'py>(
    model: &Bound<'py, PyModel>,
    q: &Bound<'py, PyAny>,
    out: Option<&Bound<'py, PyAny>>,
) -> PyResult<Array<'py>> {
    let m = &*model.get().model;
    call(
        model,
        &[argument("q", q, &[m.nq()])],
        &[m.nv()],
        out,
        hot!(m, gravity),
    )
}

/// Mass matrix M(q), (..., nv, nv), rotors included. q (..., nq). [Featherstone 2008, table 6.2]
#[pyfunction]
#[pyo3(signature = (model, q, *, out=None))]
pub(crate) fn mass_matrix<'py>(
    model: &Bound<'py, PyModel>,
    q: &Bound<'py, PyAny>,
    out: Option<&Bound<'py, PyAny>>,
) -> PyResult<Array<'py>> {
    let m = &*model.get().model;
    let tail = [m.nv(), m.nv()];
    call(
        model,
        &[argument("q", q, &[m.nq()])],
        &tail,
        out,
        hot!(m, crba),
    )
}

/// Inverse of the mass matrix, (..., nv, nv). q (..., nq). [Carpentier 2018]
#[pyfunction]
#[pyo3(signature = (model, q, *, out=None))]
pub(crate) fn mass_matrix_inverse<'py>(
    model: &Bound<'py, PyModel>,
    q: &Bound<'py, PyAny>,
    out: Option<&Bound<'py, PyAny>>,
) -> PyResult<Array<'py>> {
    let m = &*model.get().model;
    let one = |memory: &mut Of<f64>, x: &[&[f64]], out: &mut [f64]| {
        let scratch = memory
            .inverse
            .get_or_insert_with(|| MassMatrixInverseScratch::new(m));
        d::mass_matrix_inverse_into(m, x[0], scratch, &mut memory.square);
        write_matrix(&memory.square, out);
    };
    let work = Work {
        one: &|memory, x, out| one(&mut memory.one, x, out),
        wide: None,
    };
    call(
        model,
        &[argument("q", q, &[m.nq()])],
        &[m.nv(), m.nv()],
        out,
        work,
    )
}

/// C(q, v) with C v = Coriolis and centrifugal forces and dM/dt - 2 C skew, (..., nv, nv).
///
/// q (..., nq), v (..., nv). [Echeandia, Wensing 2021]
#[pyfunction]
#[pyo3(signature = (model, q, v, *, out=None))]
pub(crate) fn coriolis_matrix<'py>(
    model: &Bound<'py, PyModel>,
    q: &Bound<'py, PyAny>,
    v: &Bound<'py, PyAny>,
    out: Option<&Bound<'py, PyAny>>,
) -> PyResult<Array<'py>> {
    let m = &*model.get().model;
    let one = |memory: &mut Of<f64>, x: &[&[f64]], out: &mut [f64]| {
        let scratch = memory
            .coriolis
            .get_or_insert_with(|| CoriolisScratch::new(m));
        d::coriolis_matrix_into(m, x[0], x[1], scratch, &mut memory.square);
        write_matrix(&memory.square, out);
    };
    let work = Work {
        one: &|memory, x, out| one(&mut memory.one, x, out),
        wide: None,
    };
    let (nq, nv) = ([m.nq()], [m.nv()]);
    let arguments = [argument("q", q, &nq), argument("v", v, &nv)];
    call(model, &arguments, &[m.nv(), m.nv()], out, work)
}

/// Derivatives of inverse dynamics in one array (..., 3, nv, nv): by q, v, a.
#[pyfunction]
#[pyo3(signature = (model, q, v, a, *, out=None))]
pub(crate) fn _inverse_dynamics_derivatives<'py>(
    model: &Bound<'py, PyModel>,
    q: &Bound<'py, PyAny>,
    v: &Bound<'py, PyAny>,
    a: &Bound<'py, PyAny>,
    out: Option<&Bound<'py, PyAny>>,
) -> PyResult<Array<'py>> {
    let m = &*model.get().model;
    let (nq, nv) = ([m.nq()], [m.nv()]);
    let arguments = [
        argument("q", q, &nq),
        argument("v", v, &nv),
        argument("a", a, &nv),
    ];
    let work = Work {
        one: &|memory, x, out| {
            let memory = memory.inverse_derivatives.get_or_insert_with(|| {
                (
                    InverseDynamicsDerivativesScratch::new(m),
                    InverseDynamicsDerivatives::zeros(m),
                )
            });
            d::inverse_dynamics_derivatives_into(
                m,
                x[0],
                x[1],
                x[2],
                &[],
                &mut memory.0,
                &mut memory.1,
            );
            write_all([&memory.1.dq, &memory.1.dv, &memory.1.da], out);
        },
        wide: None,
    };
    call(model, &arguments, &[3, m.nv(), m.nv()], out, work)
}

/// Derivatives of forward dynamics in one array (..., 3, nv, nv): by q, v, tau.
#[pyfunction]
#[pyo3(signature = (model, q, v, tau, *, out=None))]
pub(crate) fn _forward_dynamics_derivatives<'py>(
    model: &Bound<'py, PyModel>,
    q: &Bound<'py, PyAny>,
    v: &Bound<'py, PyAny>,
    tau: &Bound<'py, PyAny>,
    out: Option<&Bound<'py, PyAny>>,
) -> PyResult<Array<'py>> {
    let m = &*model.get().model;
    let (nq, nv) = ([m.nq()], [m.nv()]);
    let arguments = [
        argument("q", q, &nq),
        argument("v", v, &nv),
        argument("tau", tau, &nv),
    ];
    let work = Work {
        one: &|memory, x, out| {
            let memory = memory.forward_derivatives.get_or_insert_with(|| {
                (
                    ForwardDynamicsDerivativesScratch::new(m),
                    ForwardDynamicsDerivatives::zeros(m),
                )
            });
            d::forward_dynamics_derivatives_into(
                m,
                x[0],
                x[1],
                x[2],
                &[],
                &mut memory.0,
                &mut memory.1,
            );
            write_all([&memory.1.dq, &memory.1.dv, &memory.1.dtau], out);
        },
        wide: None,
    };
    call(model, &arguments, &[3, m.nv(), m.nv()], out, work)
}

/// Matrices one after the other.
fn write_all<const N: usize>(matrices: [&DMatrix<f64>; N], out: &mut [f64]) {
    let mut rest = out;
    for matrix in matrices {
        let (own, others) = rest.split_at_mut(matrix.len());
        write_matrix(matrix, own);
        rest = others;
    }
}

fn scalar(_: &Model) -> Vec<usize> {
    Vec::new()
}

fn three(_: &Model) -> Vec<usize> {
    vec![3]
}

fn six(_: &Model) -> Vec<usize> {
    vec![6]
}

fn pose(_: &Model) -> Vec<usize> {
    vec![4, 4]
}

fn six_by_six(_: &Model) -> Vec<usize> {
    vec![6, 6]
}

fn nv(model: &Model) -> Vec<usize> {
    vec![model.nv()]
}

fn three_by_nv(model: &Model) -> Vec<usize> {
    vec![3, model.nv()]
}

fn six_by_nv(model: &Model) -> Vec<usize> {
    vec![6, model.nv()]
}

fn two_six_by_nv(model: &Model) -> Vec<usize> {
    vec![2, 6, model.nv()]
}

functions! {
    /// Kinetic energy, (...), J. q (..., nq), v (..., nv).
    kinetic_energy(q, v) -> scalar, |m, x, out| out[0] = d::kinetic_energy(m, x[0], x[1]);

    /// Potential energy of gravity, -m g' p_com, (...), J: it grows with height. q (..., nq).
    potential_energy(q) -> scalar, |m, x, out| out[0] = d::potential_energy(m, x[0]);

    /// Energy of the joints' springs, (...), J. q (..., nq).
    elastic_energy(q) -> scalar, |m, x, out| out[0] = d::elastic_energy(m, x[0]);

    /// Forces of springs and damping, (..., nv), N·m or N. q (..., nq), v (..., nv).
    passive_forces(q, v) -> nv, |m, x, out| d::passive_forces_into(m, x[0], x[1], out);

    /// Centre of mass in the world, (..., 3), m. q (..., nq).
    center_of_mass(q) -> three, |m, x, out| write_vector3(&d::center_of_mass(m, x[0]), out);

    /// Velocity of the centre of mass in the world, (..., 3), m/s. q (..., nq), v (..., nv).
    center_of_mass_velocity(q, v) -> three, |m, x, out| write_vector3(&d::center_of_mass_velocity(m, x[0], x[1]), out);

    /// Acceleration of the centre of mass in the world, (..., 3), m/s². q (..., nq), v and a (..., nv).
    center_of_mass_acceleration(q, v, a) -> three, |m, x, out| {
        write_vector3(&d::center_of_mass_acceleration(m, x[0], x[1], x[2]), out);
    };

    /// Jacobian of the centre of mass: its velocity is J v, (..., 3, nv). q (..., nq).
    center_of_mass_jacobian(q) -> three_by_nv, |m, x, out| write_matrix(&d::center_of_mass_jacobian(m, x[0]), out);

    /// Derivative of the centre of mass in tangent directions of q, (..., 3, nv), m. q (..., nq).
    center_of_mass_derivatives(q) -> three_by_nv, |m, x, out| write_matrix(&d::center_of_mass_derivatives(m, x[0]), out);

    /// Momentum about the centre of mass, [linear; angular], (..., 6), kg·m/s and kg·m²/s. q (..., nq), v (..., nv).
    centroidal_momentum(q, v) -> six, |m, x, out| write_force(&d::centroidal_momentum(m, x[0], x[1]), out);

    /// Matrix A of the centroidal momentum A v, (..., 6, nv). q (..., nq). [Orin, Goswami, Lee 2013]
    centroidal_momentum_matrix(q) -> six_by_nv, |m, x, out| write_matrix(&d::centroidal_momentum_matrix(m, x[0]), out);

    /// Rate of the centroidal momentum, (..., 6), N and N·m. q (..., nq), v and a (..., nv).
    centroidal_momentum_rate(q, v, a) -> six, |m, x, out| {
        write_force(&d::centroidal_momentum_rate(m, x[0], x[1], x[2]), out);
    };

    /// Rate of the centroidal momentum matrix along v, (..., 6, nv). q (..., nq), v (..., nv).
    centroidal_momentum_matrix_derivative(q, v) -> six_by_nv, |m, x, out| {
        write_matrix(&d::centroidal_momentum_matrix_derivative(m, x[0], x[1]), out);
    };

    /// Derivatives of the centroidal momentum in one array (..., 2, 6, nv): by q, v.
    _centroidal_momentum_derivatives(q, v) -> two_six_by_nv, |m, x, out| {
        let derivatives = d::centroidal_momentum_derivatives(m, x[0], x[1]);
        write_all([&derivatives.dq, &derivatives.dv], out);
    };

    /// Matrix Y with tau = Y p, p the ten inertial parameters of each body, (..., nv, 10 n_bodies). q (..., nq), v and a (..., nv).
    joint_torque_regressor(q, v, a) -> |m| vec![m.nv(), 10 * m.n_bodies()], |m, x, out| {
        write_matrix(&d::joint_torque_regressor(m, x[0], x[1], x[2]), out);
    };

    /// Row y with T = y p, p the ten inertial parameters of each body, (..., 10 n_bodies). q (..., nq), v (..., nv).
    kinetic_energy_regressor(q, v) -> |m| vec![10 * m.n_bodies()], |m, x, out| {
        out.copy_from_slice(d::kinetic_energy_regressor(m, x[0], x[1]).as_slice());
    };

    /// Row y with U = y p, p the ten inertial parameters of each body, (..., 10 n_bodies). q (..., nq).
    potential_energy_regressor(q) -> |m| vec![10 * m.n_bodies()], |m, x, out| {
        out.copy_from_slice(d::potential_energy_regressor(m, x[0]).as_slice());
    };

    /// Poses of all frames in the world, in the order of ``model.frame_names``, (..., n_frames, 4, 4). q (..., nq).
    forward_kinematics(q) -> |m| vec![m.frames().len(), 4, 4], |m, x, out| {
        let kinematics = d::forward_kinematics(m, x[0], &vec![0.0; m.nv()]);
        for (k, out) in out.chunks_mut(16).enumerate() {
            write_pose(&d::frame_pose_at(m, &kinematics, dualbody::model::FrameId(k)), out);
        }
    };

    /// Second derivatives of tau in (q, v, a), tangent: (..., nv, 3 nv, 3 nv). q (..., nq), v and a (..., nv).
    inverse_dynamics_second_derivatives(q, v, a) -> |m| vec![m.nv(), 3 * m.nv(), 3 * m.nv()], |m, x, out| {
        let all = d::inverse_dynamics_second_derivatives(m, x[0], x[1], x[2]);
        let width = 9 * m.nv() * m.nv();
        all.iter().zip(out.chunks_mut(width.max(1))).for_each(|(matrix, out)| write_matrix(matrix, out));
    };
}

frame_functions! {
    /// Velocity of a frame, [linear; angular], (..., 6), m/s and rad/s. q (..., nq), v (..., nv).
    frame_velocity(q, v) -> six, |m, _, x, frame, representation, out| {
        write_motion(&d::frame_velocity(m, x[0], x[1], frame, representation), out);
    };

    /// Acceleration of a frame, [linear; angular], (..., 6): classical if mixed, else spatial. q (..., nq), v and a (..., nv).
    frame_acceleration(q, v, a) -> six, |m, _, x, frame, representation, out| {
        write_motion(&d::frame_acceleration(m, x[0], x[1], x[2], frame, representation), out);
    };

    /// Acceleration of a frame where a is zero: the rate of its Jacobian times v, (..., 6). q (..., nq), v (..., nv).
    frame_bias_acceleration(q, v) -> six, |m, _, x, frame, representation, out| {
        write_motion(&d::frame_bias_acceleration(m, x[0], x[1], frame, representation), out);
    };

    /// Jacobian of a frame: its velocity is J v, (..., 6, nv). q (..., nq); representation "body", "mixed" or "inertial".
    frame_jacobian(q) -> six_by_nv, |m, memory, x, frame, representation, out| {
        d::frame_jacobian_into(m, x[0], frame, representation, &mut memory.frame);
        write_matrix(&memory.frame, out);
    };

    /// Rate of a frame's Jacobian along v, (..., 6, nv). q (..., nq), v (..., nv).
    frame_jacobian_derivative(q, v) -> six_by_nv, |m, memory, x, frame, representation, out| {
        d::frame_jacobian_derivative_into(m, x[0], x[1], frame, representation, &mut memory.frame);
        write_matrix(&memory.frame, out);
    };

    /// Derivatives of a frame's velocity in one array (..., 2, 6, nv): by q, v.
    _frame_velocity_derivatives(q, v) -> two_six_by_nv, |m, _, x, frame, representation, out| {
        let derivatives = d::frame_velocity_derivatives(m, x[0], x[1], frame, representation);
        write_all([&derivatives.dq, &derivatives.dv], out);
    };
}

placement_functions! {
    /// Pose of a frame or link in the world as a matrix [[R, p], [0, 1]], (..., 4, 4). q (..., nq).
    frame_pose(q) -> pose, |m, x, frame, out| write_pose(&d::frame_pose(m, x[0], frame), out);

    /// Derivative of a frame's pose in tangent directions of q, as a motion in the frame, (..., 6, nv). q (..., nq).
    frame_placement_derivatives(q) -> six_by_nv, |m, x, frame, out| {
        write_matrix(&d::frame_placement_derivatives(m, x[0], frame), out);
    };

}

momentum_functions! {
    /// Momentum of all bodies in a frame ("centroidal", "world", "base"), [linear; angular], (..., 6). q (..., nq), v (..., nv).
    momentum(q, v) -> six, |m, x, frame, out| write_force(&d::momentum(m, x[0], x[1], frame), out);

    /// Matrix of the momentum, (..., 6, nv). q (..., nq).
    momentum_matrix(q) -> six_by_nv, |m, x, frame, out| write_matrix(&d::momentum_matrix(m, x[0], frame), out);

    /// Inertia of the robot as one body, (..., 6, 6). q (..., nq).
    locked_inertia(q) -> six_by_six, |m, x, frame, out| {
        let inertia = d::locked_inertia(m, x[0], frame).to_matrix();
        for i in 0..6 {
            for j in 0..6 {
                out[6 * i + j] = inertia[(i, j)];
            }
        }
    };

    /// Velocity that the robot would have as one body of the same momentum, (..., 6). q (..., nq), v (..., nv).
    average_velocity(q, v) -> six, |m, x, frame, out| write_motion(&d::average_velocity(m, x[0], x[1], frame), out);

    /// Matrix of the average velocity, (..., 6, nv). q (..., nq).
    average_velocity_jacobian(q) -> six_by_nv, |m, x, frame, out| {
        write_matrix(&d::average_velocity_jacobian(m, x[0], frame), out);
    };
}

base_functions! {
    /// Velocity whose base part is in another representation, (..., nv). q (..., nq), v (..., nv).
    velocity_to_representation(q, v), |m, x, to| d::velocity_to_representation(m, x[0], x[1], to);

    /// Velocity of this library from one whose base part is in another representation, (..., nv). q (..., nq), v (..., nv).
    velocity_from_representation(q, v), |m, x, from| d::velocity_from_representation(m, x[0], x[1], from);

    /// Joint forces whose base part is in another representation, (..., nv). q (..., nq), tau (..., nv).
    force_to_representation(q, tau), |m, x, to| d::force_to_representation(m, x[0], x[1], to);

    /// Joint forces of this library from some whose base part is in another representation, (..., nv). q (..., nq), tau (..., nv).
    force_from_representation(q, tau), |m, x, from| d::force_from_representation(m, x[0], x[1], from);

    /// Acceleration whose base part is in another representation, (..., nv). q (..., nq), v and a (..., nv).
    acceleration_to_representation(q, v, a), |m, x, to| d::acceleration_to_representation(m, x[0], x[1], x[2], to);

    /// Acceleration of this library from one whose base part is in another representation, (..., nv). q (..., nq), v and a (..., nv).
    acceleration_from_representation(q, v, a), |m, x, from| d::acceleration_from_representation(m, x[0], x[1], x[2], from);
}

/// Jacobian of one configuration for velocities whose base part is in another representation. q (nq,), jacobian (rows, nv).
#[pyfunction]
pub(crate) fn jacobian_to_representation<'py>(
    model: &Bound<'py, PyModel>,
    q: &Bound<'py, PyAny>,
    jacobian: &Bound<'py, PyAny>,
    representation: &str,
) -> PyResult<Array<'py>> {
    let m = &*model.get().model;
    let (q, jacobian) = (
        read_vector("q", q, Some(m.nq()))?,
        columns("jacobian", jacobian, m)?,
    );
    let to = self::representation(representation)?;
    Ok(crate::arrays::matrix(
        model.py(),
        &d::jacobian_to_representation(m, &q, &jacobian, to),
    ))
}

/// Mass matrix of one configuration for velocities whose base part is in another representation. q (nq,), mass_matrix (nv, nv).
#[pyfunction]
pub(crate) fn mass_matrix_to_representation<'py>(
    model: &Bound<'py, PyModel>,
    q: &Bound<'py, PyAny>,
    mass_matrix: &Bound<'py, PyAny>,
    representation: &str,
) -> PyResult<Array<'py>> {
    let m = &*model.get().model;
    let (q, matrix) = (
        read_vector("q", q, Some(m.nq()))?,
        columns("mass_matrix", mass_matrix, m)?,
    );
    if matrix.nrows() != m.nv() {
        return Err(value_error("mass_matrix is not square"));
    }
    let to = self::representation(representation)?;
    Ok(crate::arrays::matrix(
        model.py(),
        &d::mass_matrix_to_representation(m, &q, &matrix, to),
    ))
}

fn columns(name: &'static str, value: &Bound<'_, PyAny>, model: &Model) -> PyResult<DMatrix<f64>> {
    let matrix = read_matrix(name, value)?;
    if matrix.ncols() == model.nv() {
        return Ok(matrix);
    }
    let shape = matrix.shape();
    Err(value_error(format_args!(
        "{name} has the shape {shape:?}, expected (rows, {})",
        model.nv()
    )))
}

/// Forces on the bodies in their frames, (n_bodies, 6), from forces on frames and links by name: what `external` of the dynamics takes.
///
/// q (nq,); forces {name: (6,)}: [linear; angular] (N, N·m) in a representation.
#[pyfunction]
#[pyo3(signature = (model, q, forces, representation="mixed"))]
pub(crate) fn external_forces<'py>(
    model: &Bound<'py, PyModel>,
    q: &Bound<'py, PyAny>,
    forces: &Bound<'py, PyDict>,
    representation: &str,
) -> PyResult<Array<'py>> {
    let m = &*model.get().model;
    let q = read_vector("q", q, Some(m.nq()))?;
    let representation = self::representation(representation)?;
    let mut named = NamedForces::default();
    for (name, force) in forces {
        let force = read_vector("forces", &force, Some(6))?;
        let force = Force::from_array(std::array::from_fn(|k| force[k]));
        let name: String = name.extract()?;
        named
            .add_frame_force(m, &name, &force, representation)
            .or_raise()?;
    }
    let kinematics = d::forward_kinematics(m, &q, &vec![0.0; m.nv()]);
    let bodies = d::external_forces(m, &kinematics, &named);
    let array = crate::arrays::empty(model.py(), &[m.n_bodies(), 6]);
    let out = crate::arrays::numbers_mut(&array);
    out.chunks_mut(6)
        .zip(&bodies)
        .for_each(|(out, force)| write_force(force, out));
    Ok(array)
}

/// Raises a ValueError that names the joints that nothing resists, if the mass matrix is singular.
#[pyfunction]
pub(crate) fn check_mass_matrix(model: &Bound<'_, PyModel>) -> PyResult<()> {
    model.get().model.check_mass_matrix().or_raise()
}
