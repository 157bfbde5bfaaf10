//! Gradients through steps, and what those through rollouts have in common with them.

use std::ops::Range;

use dualbody::linearize::{StepGradient, VjpScratch};
use dualbody::sim::SimulatorParameterGroup;
use nalgebra::DVector;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use rayon::prelude::*;

use super::given::{check_finite, row};
use super::handle::PySimulator;
use super::memory::check_batch;
use crate::arrays::{Array, Rows, argument, common_batch, empty, numbers_mut};
use crate::errors::guarded;
use crate::model::PyModel;
use crate::threads::on_pool;

/// Gradients of fewer states than this are taken on the thread that asks for them.
const FEW: usize = 4;

/// Computes something for every state, on cores if there are many.
pub(super) fn each<M, R: Send>(
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
pub(crate) fn stack<'py, 'a>(
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
    /// Gradient of ⟨adjoint, next state⟩, the vector-Jacobian product of a step: a StepGradient (state, input, parameters, friction,
    /// simulator_parameters).
    ///
    /// q (..., nq), v (..., nv), u (..., nu), adjoint (..., n_tangent): weights of the tangent of the next state. The cost is three to six steps, for
    /// any number of parameters. parameters: False omits parameters and friction.
    #[pyo3(signature = (q, v, u, adjoint, *, contact=None, models=None, parameters=true))]
    fn vjp<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        u: &Bound<'py, PyAny>,
        adjoint: &Bound<'py, PyAny>,
        contact: Option<&Bound<'py, PyAny>>,
        models: Option<Vec<Py<PyModel>>>,
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
        check_batch(&batch, models.is_some())?;
        let variants = self.variants(models.as_deref(), count)?;
        let weights: Vec<&[f64]> = (0..count).map(|k| row(&adjoint, k, n)).collect();
        let one = |scratch: &mut VjpScratch, k: usize| {
            let mut out = StepGradient::zeros(own);
            if !parameters {
                out = out.without_parameters();
            }
            let u = &inputs[k * nu..(k + 1) * nu];
            match &variants {
                None => own.vjp_into(&states[k], u, weights[k], scratch, &mut out),
                Some(all) => {
                    let (own, mut scratch) = (&all[k], VjpScratch::new(&all[k]));
                    own.vjp_into(&states[k], u, weights[k], &mut scratch, &mut out);
                }
            }
            out
        };
        let all = each(py, count, || VjpScratch::new(own), one)?;
        let (p, f) = self.parameter_sizes(parameters);
        let friction = self.friction_of(f, all.iter().map(|g| g.parameters.as_slice()));
        let arrays = (
            stack(py, &batch, &[n], all.iter().map(|g| g.state.as_slice())),
            stack(py, &batch, &[nu], all.iter().map(|g| g.input.as_slice())),
            stack(
                py,
                &batch,
                &[p],
                all.iter().map(|g| &g.parameters.as_slice()[..p]),
            ),
            stack(py, &batch, &[f], friction.iter().map(Vec::as_slice)),
            self.all_parameters(py, &batch, parameters, all.iter().map(|g| &g.parameters)),
        );
        static CLASS: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
        CLASS
            .import(py, "dualbody.sim", "StepGradient")?
            .call1(arrays)
    }
}

impl PySimulator {
    /// Slopes in the friction of each point of contact, from those in all parameters; of no point if `count` is zero.
    pub(super) fn friction_of<'a>(
        &self,
        count: usize,
        parameters: impl Iterator<Item = &'a [f64]>,
    ) -> Vec<Vec<f64>> {
        let layout = self.simulator.parameter_layout();
        let laws = layout
            .groups()
            .iter()
            .filter(|(group, _)| matches!(group, SimulatorParameterGroup::ContactLaw(_)));
        let of_law = |range: &Range<usize>| {
            let is_friction = |&k: &usize| layout.names()[k].ends_with(": friction");
            range.clone().find(is_friction)
        };
        let slots: Vec<usize> = laws
            .filter_map(|(_, range)| of_law(range))
            .take(count)
            .collect();
        let gather = |all: &[f64]| slots.iter().map(|&k| all[k]).collect();
        parameters.map(gather).collect()
    }

    /// Slopes in all parameters of the simulator; of none if they are not wanted.
    pub(super) fn all_parameters<'a, 'py>(
        &self,
        py: Python<'py>,
        batch: &[usize],
        wanted: bool,
        rows: impl Iterator<Item = &'a DVector<f64>>,
    ) -> Array<'py> {
        let width = match wanted {
            true => self.simulator.parameters().len(),
            false => 0,
        };
        stack(
            py,
            batch,
            &[width],
            rows.map(|row| &row.as_slice()[..width]),
        )
    }

    /// Numbers of parameters and of coefficients of friction, zero if they are not wanted.
    pub(super) fn parameter_sizes(&self, wanted: bool) -> (usize, usize) {
        let own = &*self.simulator;
        let points = own.contacts().map_or(0, |c| c.points().len());
        match wanted {
            true => (own.model().parameter_layout().names().len(), points),
            false => (0, 0),
        }
    }
}
