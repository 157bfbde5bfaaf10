//! Jacobians of a step.

use dualbody::linearize::{LinearizeScratch, RateScratch};
use dualbody::{Linearization, State};
use pyo3::prelude::*;

use super::given::Given;
use super::handle::PySimulator;
use super::memory::check_batch;
use crate::arrays::{Array, numbers_mut, room, write_matrix};
use crate::errors::guarded;
use crate::model::PyModel;
use crate::python::{methods, of_package};
use crate::scratch::with_kept;
use crate::threads::each;

/// Arrays of A and B, one pair for each state of a batch.
pub(crate) struct Jacobians<'py> {
    a: Array<'py>,
    b: Array<'py>,
}

impl<'py> Jacobians<'py> {
    fn new(py: Python<'py>, simulator: &PySimulator, batch: &[usize]) -> PyResult<Self> {
        let own = &simulator.simulator;
        let (n, nu) = (own.n_tangent(), own.nu());
        let array = |columns: usize| room(py, &[batch, &[n, columns]].concat());
        Ok(Self {
            a: array(n)?,
            b: array(nu)?,
        })
    }

    pub(crate) fn write_all(&self, all: &[Linearization]) {
        let rows = all.iter().enumerate();
        rows.for_each(|(k, linear)| self.write(k, linear));
    }

    fn write(&self, k: usize, linear: &Linearization) {
        for (array, matrix) in [(&self.a, &linear.a), (&self.b, &linear.b)] {
            let start = k * matrix.len();
            let out = &mut numbers_mut(array)[start..start + matrix.len()];
            write_matrix(matrix, out);
        }
    }
}

methods! { PySimulator {
    /// Jacobians of the step in tangent coordinates: a (..., n_tangent, n_tangent), b (..., n_tangent, nu). Arguments as in step.
    ///
    /// δq is a tangent vector, as from Model.difference: three entries for a rotation of a ball joint or base, in body axes, not the four of a
    /// quaternion. Where contacts begin or end the Jacobians are those of one side. With soft contact the state includes its bristles.
    fn linearize(&self, q, v, u = None, *, contact = None, models: Option<Vec<Py<PyModel>>> = None) -> PyResult<Bound<'py, PyAny>> {
        let given = self.read(q, v, u, contact)?;
        check_batch(&given.batch, models.is_some())?;
        self.jacobians(q.py(), &given, |out| match given.batch.is_empty() {
            true => self.linearize_one(&given, out),
            false => self.linearize_batch(q.py(), &given, models.as_deref(), out),
        })
    }

    /// Jacobians of the rate (v, acceleration) in continuous time, in tangent coordinates: shapes and arguments as in linearize.
    ///
    /// Raises ValueError with rigid contact, whose forces act over a step. [Carpentier, Mansard 2018]
    fn linearize_rate(&self, q, v, u = None, *, contact = None) -> PyResult<Bound<'py, PyAny>> {
        let given = self.read(q, v, u, contact)?;
        let own = &*self.simulator;
        let one = |state: &State, u: &[f64], out: &mut Linearization| {
            let rate = |scratch: &mut _| own.linearize_rate_into(state, u, scratch, out);
            with_kept(self.id, || RateScratch::new(own), rate);
        };
        self.jacobians(q.py(), &given, |out| {
            self.linearize_each(q.py(), &given, out, one)
        })
    }
} }

impl PySimulator {
    /// A `Linearization` of arrays for all states, once they are written.
    pub(crate) fn jacobians<'py>(
        &self,
        py: Python<'py>,
        given: &Given<'_>,
        write: impl FnOnce(&Jacobians<'py>) -> PyResult<()>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let out = Jacobians::new(py, self, &given.batch)?;
        write(&out)?;
        let class = of_package!(py, "sim", "Linearization");
        class.call1((out.a, out.b))
    }

    fn linearize_one(&self, given: &Given<'_>, out: &Jacobians<'_>) -> PyResult<()> {
        let own = &*self.simulator;
        self.with_memory(given, |memory| {
            let new = || (LinearizeScratch::new(own), Linearization::zeros(own));
            let (scratch, linear) = memory.linear.get_or_insert_with(new);
            own.linearize_into(&memory.state, &memory.u, scratch, linear);
            out.write(0, linear);
        })
    }

    fn linearize_batch(
        &self,
        py: Python<'_>,
        given: &Given<'_>,
        models: Option<&[Py<PyModel>]>,
        out: &Jacobians<'_>,
    ) -> PyResult<()> {
        let count = given.count();
        let (states, inputs) = (self.states(given, count)?, self.inputs(given, count)?);
        let all = py.detach(|| self.linearize_states(&states, &inputs, models))?;
        out.write_all(&all);
        Ok(())
    }

    /// Jacobians of the steps of some states; the interpreter lock is not needed.
    pub(crate) fn linearize_states(
        &self,
        states: &[State],
        inputs: &[f64],
        models: Option<&[Py<PyModel>]>,
    ) -> PyResult<Vec<Linearization>> {
        match states {
            [] => Ok(Vec::new()),
            [state] if models.is_none() => {
                guarded(|| vec![self.simulator.linearize(state, inputs)])
            }
            _ => self.on_batch(states.len(), models, |batch| {
                batch.simulator.linearize(states, inputs)
            }),
        }
    }

    /// Jacobians of one state, or of those of a batch on the pool.
    pub(super) fn linearize_each(
        &self,
        py: Python<'_>,
        given: &Given<'_>,
        out: &Jacobians<'_>,
        one: impl Fn(&State, &[f64], &mut Linearization) + Send + Sync,
    ) -> PyResult<()> {
        let (own, count) = (&*self.simulator, given.count());
        let (states, inputs) = (self.states(given, count)?, self.inputs(given, count)?);
        let one = |k: usize| {
            let mut linear = Linearization::zeros(own);
            let u = &inputs[k * own.nu()..(k + 1) * own.nu()];
            one(&states[k], u, &mut linear);
            linear
        };
        out.write_all(&py.detach(|| each(count, one))?);
        Ok(())
    }
}
