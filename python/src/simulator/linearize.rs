//! Jacobians of a step.

use dualbody::Linearization;
use dualbody::linearize::{LinearizeScratch, RateScratch};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;

use super::given::Given;
use super::handle::PySimulator;
use crate::arrays::{Array, empty, numbers_mut, write_matrix};
use crate::errors::guarded;

/// Arrays of A and B, one pair for each state of a batch.
struct Jacobians<'py> {
    a: Array<'py>,
    b: Array<'py>,
}

impl<'py> Jacobians<'py> {
    fn new(py: Python<'py>, simulator: &PySimulator, batch: &[usize]) -> Self {
        let own = &simulator.simulator;
        let (n, nu) = (own.n_tangent(), own.nu());
        let array = |columns: usize| empty(py, &[batch, &[n, columns]].concat());
        Self {
            a: array(n),
            b: array(nu),
        }
    }

    fn write(&self, k: usize, linear: &Linearization) {
        for (array, matrix) in [(&self.a, &linear.a), (&self.b, &linear.b)] {
            let start = k * matrix.len();
            let out = &mut numbers_mut(array)[start..start + matrix.len()];
            write_matrix(matrix, out);
        }
    }
}

#[pymethods]
impl PySimulator {
    /// Jacobians of the step in tangent coordinates: a (..., n_tangent, n_tangent), b (..., n_tangent, nu). Arguments as in step.
    #[pyo3(signature = (q, v, u=None, *, contact=None))]
    fn linearize<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        u: Option<&Bound<'py, PyAny>>,
        contact: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = q.py();
        let given = self.read(q, v, u, contact)?;
        let out = Jacobians::new(py, self, &given.batch);
        match given.batch.is_empty() {
            true => self.linearize_one(&given, &out)?,
            false => self.linearize_batch(py, &given, &out)?,
        }
        static CLASS: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
        let class = CLASS.import(py, "dualbody.sim", "Linearization")?;
        class.call1((out.a, out.b))
    }

    /// Jacobians of the rate (v, acceleration) in continuous time, in tangent coordinates: shapes and arguments as in linearize.
    ///
    /// Raises ValueError where rigid contact acts, whose forces are those of a step. [Carpentier, Mansard 2018]
    #[pyo3(signature = (q, v, u=None, *, contact=None))]
    fn linearize_rate<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        u: Option<&Bound<'py, PyAny>>,
        contact: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = q.py();
        let given = self.read(q, v, u, contact)?;
        let out = Jacobians::new(py, self, &given.batch);
        let (own, count) = (&*self.simulator, given.count());
        let (states, inputs) = (self.states(&given, count)?, self.inputs(&given, count)?);
        guarded(|| {
            let (mut scratch, mut linear) = (RateScratch::new(own), Linearization::zeros(own));
            for (k, state) in states.iter().enumerate() {
                let u = &inputs[k * own.nu()..(k + 1) * own.nu()];
                own.linearize_rate_into(state, u, &mut scratch, &mut linear);
                out.write(k, &linear);
            }
        })?;
        let class = py.import("dualbody.sim")?.getattr("Linearization")?;
        class.call1((out.a, out.b))
    }
}

impl PySimulator {
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
        out: &Jacobians<'_>,
    ) -> PyResult<()> {
        let count = given.count();
        if count == 0 {
            return Ok(());
        }
        let (states, inputs) = (self.states(given, count)?, self.inputs(given, count)?);
        let all = self.on_batch(py, count, |batch| batch.linearize(&states, &inputs))?;
        let rows = all.iter().enumerate();
        rows.for_each(|(k, linear)| out.write(k, linear));
        Ok(())
    }
}
