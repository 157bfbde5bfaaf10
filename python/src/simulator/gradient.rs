//! Gradients through steps and rollouts.

use dualbody::linearize::{
    Checkpoints, RolloutCost, RolloutGradient, RolloutGradientOptions, StepGradient, VjpScratch,
};
use dualbody::sim::RolloutStatus;
use dualbody::{Scalar, State};
use nalgebra::DVector;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use rayon::prelude::*;

use super::given::{check_finite, row};
use super::handle::PySimulator;
use super::trajectories::status_of;
use crate::arrays::{Array, Rows, argument, common_batch, empty, numbers_mut};
use crate::errors::{guarded, value_error};
use crate::threads::on_pool;

/// Gradients of fewer states than this are taken on the thread that asks for them.
const FEW: usize = 4;

/// A cost that is linear in the numbers of states and inputs: what a gradient in them makes of any cost.
struct Weighted<'a> {
    steps: usize,
    q: Option<&'a [f64]>,
    v: Option<&'a [f64]>,
    contact: Option<&'a [f64]>,
    u: Option<&'a [f64]>,
}

/// Sum of numbers with the weights of a step; zero without weights.
fn weighted<T: Scalar>(weights: Option<&[f64]>, step: usize, x: &[T]) -> T {
    let own = weights.map_or(&[][..], |all| &all[step * x.len()..(step + 1) * x.len()]);
    let products = own.iter().zip(x).map(|(&w, &x)| x * w);
    products.fold(T::zero(), |sum, product| sum + product)
}

impl Weighted<'_> {
    fn state<T: Scalar>(&self, step: usize, state: &State<T>) -> T {
        weighted(self.q, step, state.q.as_slice())
            + weighted(self.v, step, state.v.as_slice())
            + weighted(self.contact, step, state.contact.as_slice())
    }
}

impl RolloutCost for Weighted<'_> {
    fn stage<T: Scalar>(&self, step: usize, state: &State<T>, u: &[T]) -> T {
        self.state(step, state) + weighted(self.u, step, u)
    }

    fn end<T: Scalar>(&self, last: &State<T>) -> T {
        self.state(self.steps, last)
    }
}

/// Weights of a trajectory of a batch, of so many numbers each.
fn weights_of<'a>(rows: Option<&'a Rows<'_>>, k: usize, width: usize) -> Option<&'a [f64]> {
    rows.map(|rows| row(rows, k, width))
}

fn checkpoints_of(value: &Bound<'_, PyAny>) -> PyResult<Checkpoints> {
    if let Ok(interval) = value.extract::<usize>() {
        return Ok(Checkpoints::Every(interval.max(1)));
    }
    match value.extract::<String>().as_deref() {
        Ok("all") => Ok(Checkpoints::All),
        Ok("square_root") => Ok(Checkpoints::SquareRoot),
        _ => Err(value_error(
            "checkpoints is not \"all\", \"square_root\" or a number of steps",
        )),
    }
}

/// Computes something for every state, on cores if there are many.
fn each<M, R: Send>(
    py: Python<'_>,
    count: usize,
    memory: impl Fn() -> M + Send + Sync,
    one: impl Fn(&mut M, usize) -> R + Send + Sync,
) -> PyResult<Vec<R>> {
    if count < FEW {
        return guarded(|| {
            let mut memory = memory();
            (0..count).map(|k| one(&mut memory, k)).collect()
        });
    }
    let all = || {
        (0..count)
            .into_par_iter()
            .map_init(&memory, |memory, k| one(memory, k))
            .collect()
    };
    on_pool(py, all)
}

/// An array of the shape (batch, tail) from its rows.
fn stack<'py, 'a>(
    py: Python<'py>,
    batch: &[usize],
    tail: &[usize],
    rows: impl Iterator<Item = &'a [f64]>,
) -> Array<'py> {
    let array = empty(py, &[batch, tail].concat());
    let width: usize = tail.iter().product();
    let out = numbers_mut(&array).chunks_mut(width.max(1));
    out.zip(rows)
        .for_each(|(out, row)| out.copy_from_slice(row));
    array
}

#[pymethods]
impl PySimulator {
    /// Gradient of ⟨adjoint, next state⟩, the vector-Jacobian product of a step: a StepGradient (state, input, parameters, friction).
    ///
    /// q (..., nq), v (..., nv), u (..., nu), adjoint (..., n_tangent): weights of the tangent of the next state. Three to six steps of cost,
    /// however many parameters there are. parameters: False leaves parameters and friction out, as kinematic constraints ask for.
    #[pyo3(signature = (q, v, u, adjoint, *, contact=None, parameters=true))]
    fn vjp<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        u: &Bound<'py, PyAny>,
        adjoint: &Bound<'py, PyAny>,
        contact: Option<&Bound<'py, PyAny>>,
        parameters: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (py, own) = (q.py(), &*self.simulator);
        let (n, nu) = (own.n_tangent(), own.nu());
        let given = self.read(q, v, Some(u), contact)?;
        let adjoint = Rows::read(&argument("adjoint", adjoint, &[n]))?;
        check_finite("adjoint", adjoint.as_slice())?;
        let all = [("q", &given.batch[..]), ("adjoint", adjoint.batch())];
        let batch = common_batch(all.into_iter())?;
        let count = batch.iter().product();
        let (states, inputs) = (self.states(&given, count)?, self.inputs(&given, count)?);
        let weights: Vec<&[f64]> = (0..count).map(|k| row(&adjoint, k, n)).collect();
        let one = |scratch: &mut VjpScratch, k: usize| {
            let mut out = StepGradient::zeros(own);
            if !parameters {
                out = out.without_parameters();
            }
            let u = &inputs[k * nu..(k + 1) * nu];
            own.vjp_into(&states[k], u, weights[k], scratch, &mut out);
            out
        };
        let all = each(py, count, || VjpScratch::new(own), one)?;
        let (p, f) = self.parameter_sizes(parameters);
        let arrays = (
            stack(py, &batch, &[n], all.iter().map(|g| g.state.as_slice())),
            stack(py, &batch, &[nu], all.iter().map(|g| g.input.as_slice())),
            stack(
                py,
                &batch,
                &[p],
                all.iter().map(|g| g.parameters.as_slice()),
            ),
            stack(py, &batch, &[f], all.iter().map(|g| g.friction.as_slice())),
        );
        static CLASS: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
        CLASS
            .import(py, "dualbody.sim", "StepGradient")?
            .call1(arrays)
    }

    /// Gradient of Σₖ ⟨by_q[k], q[k]⟩ + ⟨by_v[k], v[k]⟩ + ⟨by_contact[k], contact[k]⟩ + ⟨by_u[k], u[k]⟩ over a rollout, the vector-Jacobian
    /// product of all its steps: a RolloutGradient (start, inputs, parameters, friction, status).
    ///
    /// q (..., nq), v (..., nv), inputs (..., steps, nu) or (steps, nu) for all; by_q (..., steps + 1, nq) in coordinates, by_v (..., steps + 1, nv),
    /// by_contact (..., steps + 1, n_contact), by_u (..., steps, nu); zero if left out. parameters: False leaves parameters and friction out;
    /// checkpoints: states that are kept, "all", "square_root", or one in so many. A trajectory that does not come to its end has no slopes.
    #[pyo3(signature = (q, v, inputs, *, by_q=None, by_v=None, by_contact=None, by_u=None, contact=None, parameters=true, checkpoints=None))]
    fn rollout_vjp<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        inputs: &Bound<'py, PyAny>,
        by_q: Option<&Bound<'py, PyAny>>,
        by_v: Option<&Bound<'py, PyAny>>,
        by_contact: Option<&Bound<'py, PyAny>>,
        by_u: Option<&Bound<'py, PyAny>>,
        contact: Option<&Bound<'py, PyAny>>,
        parameters: bool,
        checkpoints: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (py, own) = (q.py(), &*self.simulator);
        let (nq, nv, nu, nc) = self.sizes();
        let given = self.read(q, v, None, contact)?;
        let (inputs, steps) = super::inputs::read_inputs(Some(inputs), None, nu)?;
        let read = |name, value: Option<&Bound<'py, PyAny>>, shape: [usize; 2]| {
            let rows = value.map(|value| Rows::read(&argument(name, value, &shape)));
            let rows = rows.transpose()?;
            let numbers = rows.as_ref().map_or(&[][..], Rows::as_slice);
            check_finite(name, numbers).map(|()| rows)
        };
        let weights = [
            ("by_q", read("by_q", by_q, [steps + 1, nq])?),
            ("by_v", read("by_v", by_v, [steps + 1, nv])?),
            (
                "by_contact",
                read("by_contact", by_contact, [steps + 1, nc])?,
            ),
            ("by_u", read("by_u", by_u, [steps, nu])?),
            ("inputs", inputs),
        ];
        let own_batches = weights
            .iter()
            .filter_map(|(name, rows)| Some((*name, rows.as_ref()?.batch())));
        let batch = common_batch([("q", &given.batch[..])].into_iter().chain(own_batches))?;
        let count = batch.iter().product();
        let states = self.states(&given, count)?;
        let numbers = weights.each_ref().map(|(_, rows)| rows.as_ref());
        let widths = [
            (steps + 1) * nq,
            (steps + 1) * nv,
            (steps + 1) * nc,
            steps * nu,
            steps * nu,
        ];
        let rows_of = |k: usize| -> [Option<&[f64]>; 5] {
            std::array::from_fn(|i| weights_of(numbers[i], k, widths[i]))
        };
        let all: Vec<_> = (0..count).map(rows_of).collect();
        let mut options = RolloutGradientOptions::default();
        if let Some(checkpoints) = checkpoints {
            options = options.with_checkpoints(checkpoints_of(checkpoints)?);
        }
        if !parameters {
            options = options.without_parameters();
        }
        let one = |(): &mut (), k: usize| {
            let [q, v, contact, u, inputs] = all[k];
            let inputs = inputs.unwrap_or(&[]);
            let vectors =
                (0..steps).map(|k| DVector::from_column_slice(&inputs[k * nu..(k + 1) * nu]));
            let cost = Weighted {
                steps,
                q,
                v,
                contact,
                u,
            };
            own.rollout_gradient_with(&states[k], &vectors.collect::<Vec<_>>(), &cost, &options)
        };
        let all = each(py, count, || (), one)?;
        self.rollout_slopes(py, &batch, steps, parameters, &all)
    }
}

impl PySimulator {
    /// Numbers of parameters and of coefficients of friction, zero if they are not wanted.
    fn parameter_sizes(&self, wanted: bool) -> (usize, usize) {
        let own = &*self.simulator;
        let points = own.contacts().map_or(0, |c| c.points().len());
        match wanted {
            true => (own.model().parameter_layout().len(), points),
            false => (0, 0),
        }
    }

    fn rollout_slopes<'py>(
        &self,
        py: Python<'py>,
        batch: &[usize],
        steps: usize,
        parameters: bool,
        all: &[RolloutGradient],
    ) -> PyResult<Bound<'py, PyAny>> {
        let (n, nu) = (self.simulator.n_tangent(), self.simulator.nu());
        let (p, f) = self.parameter_sizes(parameters);
        let inputs: Vec<Vec<f64>> = all
            .iter()
            .map(|g| g.inputs.iter().flat_map(|u| u.iter().copied()).collect())
            .collect();
        let stopped: Vec<_> = (0..all.len())
            .filter(|&k| !matches!(all[k].status, RolloutStatus::Completed))
            .map(|k| (k, status_of(all[k].status)))
            .collect();
        let arrays = (
            stack(py, batch, &[n], all.iter().map(|g| g.start.as_slice())),
            stack(py, batch, &[steps, nu], inputs.iter().map(Vec::as_slice)),
            stack(py, batch, &[p], all.iter().map(|g| g.parameters.as_slice())),
            stack(py, batch, &[f], all.iter().map(|g| g.friction.as_slice())),
            all.len(),
            stopped,
            !batch.is_empty(),
        );
        static MAKE: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
        MAKE.import(py, "dualbody.sim", "_rollout_slopes")?
            .call1(arrays)
    }
}
