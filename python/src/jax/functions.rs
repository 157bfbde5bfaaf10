//! Functions that programs of JAX call.

use pyo3::prelude::*;

use super::frame::{Argument, Frame};
use super::registry::{Used, find};
use crate::arrays::{View, Work, map_views};
use crate::dynamics::{
    aba, forward_slopes, inverse_slopes, on_both, rnea, write_difference_jacobian,
    write_integrate_jacobian,
};
use crate::model::PyModel;
use crate::scratch::Memory;
use crate::simulator::{PySimulator, Slice};

/// Calls the function that a frame names.
pub(super) fn call(frame: &Frame<'_>) -> Result<(), String> {
    let function = frame.text("function")?;
    match find(frame.text("of")?)? {
        Used::Model(model) => dynamics(frame, function, model.get()),
        Used::Simulator(simulator) => simulation(frame, function, simulator.get()),
    }
    .map_err(|error| error.to_text())
}

/// Why a call fails: a text, or an exception that somebody else raised.
pub(super) enum Failure {
    Text(String),
    Raised(PyErr),
}

impl Failure {
    /// The text without the name of the exception.
    fn to_text(&self) -> String {
        match self {
            Self::Text(text) => text.clone(),
            Self::Raised(error) => Python::attach(|py| error.value(py).to_string()),
        }
    }
}

impl From<String> for Failure {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<PyErr> for Failure {
    fn from(error: PyErr) -> Self {
        Self::Raised(error)
    }
}

fn unknown(function: &str) -> Failure {
    Failure::Text(format!("there is no function {function}"))
}

fn dynamics(frame: &Frame<'_>, function: &str, model: &PyModel) -> Result<(), Failure> {
    let m = &*model.model;
    let (q, v) = (m.nq(), m.nv());
    let alone = |one: &Row<'_>, widths: &[usize]| {
        let wide = None;
        rows(frame, model, widths, Work { one, wide })
    };
    match function {
        "inverse_dynamics" => rows(frame, model, &[q, v, v], on_both!(m, rnea)),
        "forward_dynamics" => rows(frame, model, &[q, v, v], on_both!(m, aba)),
        "inverse_dynamics_derivatives" => alone(
            &|memory, x, out| inverse_slopes(m, memory, x, out),
            &[q, v, v],
        ),
        "forward_dynamics_derivatives" => alone(
            &|memory, x, out| forward_slopes(m, memory, x, out),
            &[q, v, v],
        ),
        "integrate_jacobian" => alone(&|_, x, out| write_integrate_jacobian(m, x[0], out), &[q]),
        "difference_jacobian" => alone(&|_, x, out| write_difference_jacobian(m, x[0], out), &[q]),
        _ => Err(unknown(function)),
    }
}

/// A function of one row, without lanes.
type Row<'a> = dyn Fn(&mut Memory, &[&[f64]], &mut [f64]) + Sync + 'a;

/// Applies a function of rows of these widths to the arguments of a frame.
fn rows(
    frame: &Frame<'_>,
    model: &PyModel,
    widths: &[usize],
    work: Work<'_>,
) -> Result<(), Failure> {
    let all = arguments(frame, widths)?;
    let views: Vec<View<'_>> = (all.iter().zip(widths))
        .map(|(argument, &width)| View::of_batch(&argument.numbers, width))
        .collect();
    let count = count(&all[0]);
    let known = (&*model.model, model.id);
    frame.fill(0, |out| {
        let done = map_views(known, &views, count, work, out);
        done.map_err(|error| Failure::from(error).to_text())
    })?;
    Ok(())
}

/// The arguments of a frame, whose last axes have these lengths.
fn arguments<'a>(frame: &Frame<'a>, widths: &[usize]) -> Result<Vec<Argument<'a>>, String> {
    let mut all: Vec<Argument<'a>> = Vec::with_capacity(widths.len());
    for (k, &width) in widths.iter().enumerate() {
        let argument = frame.argument(k)?;
        let own = argument.shape.last().copied();
        let fits = all.first().is_none_or(|q| count(q) == count(&argument));
        if own.and_then(|own| usize::try_from(own).ok()) != Some(width) || !fits {
            let shape = argument.shape;
            return Err(format!(
                "array {k} has the shape {shape:?}, expected rows of {width} numbers"
            ));
        }
        all.push(argument);
    }
    Ok(all)
}

/// Number of rows of an argument.
fn count(argument: &Argument<'_>) -> usize {
    let batch = argument
        .shape
        .split_last()
        .map_or(&[][..], |(_, batch)| batch);
    usize::try_from(batch.iter().product::<i64>()).unwrap_or(0)
}

fn simulation(frame: &Frame<'_>, function: &str, simulator: &PySimulator) -> Result<(), Failure> {
    let (nq, nv, nu, _) = simulator.sizes();
    if function == "rollout" {
        return rollout(frame, simulator);
    }
    let all = arguments(frame, &[nq, nv, nu])?;
    let [q, v, u] = [0, 1, 2].map(|k| &*all[k].numbers);
    let given = Slice {
        q,
        v,
        u,
        count: count(&all[0]),
    };
    match function {
        "step" => {
            let (q, v) = simulator.step_slice(&given)?;
            frame.copy(0, &q)?;
            frame.copy(1, &v)?;
        }
        "linearize" => {
            let (a, b) = simulator.linearize_slice(&given)?;
            frame.copy(0, &a)?;
            frame.copy(1, &b)?;
        }
        _ => return Err(unknown(function)),
    }
    Ok(())
}

/// Rollouts under inputs (…, steps, nu).
fn rollout(frame: &Frame<'_>, simulator: &PySimulator) -> Result<(), Failure> {
    let (nq, nv, nu, _) = simulator.sizes();
    let all = arguments(frame, &[nq, nv])?;
    let inputs = frame.argument(2)?;
    let steps = match *inputs.shape {
        [.., steps, own] if usize::try_from(own) == Ok(nu) => usize::try_from(steps).unwrap_or(0),
        _ => {
            let shape = inputs.shape;
            return Err(
                format!("array 2 has the shape {shape:?}, expected (…, steps, {nu})").into(),
            );
        }
    };
    let start = Slice {
        q: &all[0].numbers,
        v: &all[1].numbers,
        u: &inputs.numbers,
        count: count(&all[0]),
    };
    let states = simulator.rollout_slice(&start, steps)?;
    let part = |first: usize, length: usize| -> Vec<f64> {
        let rows = states.chunks(nq + nv).take(start.count * (steps + 1));
        rows.flat_map(|row| &row[first..first + length])
            .copied()
            .collect()
    };
    frame.copy(0, &part(0, nq))?;
    frame.copy(1, &part(nq, nv))?;
    Ok(())
}
