//! Jacobians of a step.

use dualbody::Linearization;
use dualbody::linearize::{LinearizeScratch, RateScratch};

use super::given::Given;
use super::memory::check_batch;
use crate::prelude::*;

methods! { PySimulator {
    /// Jacobians of the step in tangent coordinates: a (..., n_tangent, n_tangent), b (..., n_tangent, nu). Arguments as in step.
    ///
    /// δq is a tangent vector, as from Model.difference: three entries for a rotation of a ball joint or base, in body axes, not the four of a
    /// quaternion. Where contacts begin or end the Jacobians are those of one side. With soft contact the state includes its bristles.
    fn linearize(&self, q, v, u = None, *, contact = None, models: Option<Vec<Py<PyModel>>> = None) -> PyResult<Bound<'py, PyAny>> {
        let given = self.read(q, v, u, contact)?;
        check_batch(&given.batch, models.is_some())?;
        if given.batch.is_empty() {
            return self.linearize_one(q.py(), &given);
        }
        let (states, inputs) = self.with_room(&given)?;
        let all = (q.py()).detach(|| self.linearize_states(&states, &inputs, models.as_deref()))?;
        self.jacobians(q.py(), &given.batch, &all)
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
        self.linearize_each(q.py(), &given, one)
    }
} }

impl PySimulator {
    /// A `Linearization` of arrays.
    pub(crate) fn jacobians<'py>(
        &self,
        py: Python<'py>,
        batch: &[usize],
        all: &[Linearization],
    ) -> PyResult<Bound<'py, PyAny>> {
        let (n, nu) = (self.simulator.n_tangent(), self.simulator.nu());
        let a = matrices(py, batch, [n, n], all.iter().map(|own| &own.a))?;
        let b = matrices(py, batch, [n, nu], all.iter().map(|own| &own.b))?;
        of_package!(py, "_rollout", "Linearization").call1((a, b))
    }

    fn linearize_one<'py>(
        &self,
        py: Python<'py>,
        given: &Given<'_>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let own = &*self.simulator;
        self.with_memory(given, |memory| {
            let new = || (LinearizeScratch::new(own), Linearization::zeros(own));
            let (scratch, linear) = memory.linear.get_or_insert_with(new);
            own.linearize_into(&memory.state, &memory.u, scratch, linear);
            self.jacobians(py, &[], std::slice::from_ref(linear))
        })?
    }

    /// States and inputs of a call, if there is room for their Jacobians.
    fn with_room(&self, given: &Given<'_>) -> PyResult<(Vec<State>, Vec<f64>)> {
        let n = self.simulator.n_tangent();
        check_array("results", &[&given.batch[..], &[n, n]].concat())?;
        self.states_and_inputs(given)
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
    pub(super) fn linearize_each<'py>(
        &self,
        py: Python<'py>,
        given: &Given<'_>,
        one: impl Fn(&State, &[f64], &mut Linearization) + Send + Sync,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (own, nu) = (&*self.simulator, self.simulator.nu());
        let (states, inputs) = self.with_room(given)?;
        let one = |k: usize| {
            let mut linear = Linearization::zeros(own);
            one(&states[k], &inputs[k * nu..(k + 1) * nu], &mut linear);
            linear
        };
        let all = py.detach(|| each(states.len(), one))?;
        self.jacobians(py, &given.batch, &all)
    }
}
