//! Steps, Jacobians and rollouts of numbers that are no arrays of NumPy; the interpreter lock is not needed for steps and Jacobians.

use dualbody::linearize::LinearizeScratch;
use dualbody::sim::{BatchSimulator, RolloutStatus};
use dualbody::{Linearization, State};
use pyo3::prelude::*;

use super::given::check_finite;
use super::handle::PySimulator;
use super::inputs::Inputs;
use super::memory::One;
use super::single::{Control, roll_with_inputs};
use super::step::{diverged, write_parts};
use crate::arrays::write_matrix;
use crate::errors::{OrRaise, guarded};
use crate::threads::pool;

/// States and inputs, row after row.
pub(crate) struct Slice<'a> {
    pub(crate) q: &'a [f64],
    pub(crate) v: &'a [f64],
    /// Inputs of a step, or of all steps of a rollout.
    pub(crate) u: &'a [f64],
    pub(crate) count: usize,
}

impl PySimulator {
    /// The next (q, v).
    pub(crate) fn step_slice(&self, given: &Slice<'_>) -> PyResult<(Vec<f64>, Vec<f64>)> {
        if given.count == 1 {
            return self.step_slice_of_one(given);
        }
        let mut out = (vec![0.0; given.q.len()], vec![0.0; given.v.len()]);
        if given.count == 0 {
            return Ok(out);
        }
        let next = self.on_slice(given, |batch, states| {
            let mut all = batch.states(states);
            batch.step(&mut all, given.u);
            all
        })?;
        let stopped = |i: &usize| !matches!(next.status(*i), RolloutStatus::Completed);
        if let Some(i) = (0..given.count).find(stopped) {
            return Err(diverged(Some(i)));
        }
        write_parts(&next, &mut [&mut out.0, &mut out.1]);
        Ok(out)
    }

    fn step_slice_of_one(&self, given: &Slice<'_>) -> PyResult<(Vec<f64>, Vec<f64>)> {
        let next = self.with_memory_of(&given.one(), |memory| {
            let next = &mut memory.next;
            let (state, scratch) = (&memory.state, &mut memory.scratch);
            self.simulator.step_into(state, &memory.u, scratch, next);
            let parts = (next.q.as_slice().to_vec(), next.v.as_slice().to_vec());
            next.is_finite().then_some(parts)
        })?;
        next.ok_or_else(|| diverged(None))
    }

    /// Jacobians of the step, row by row.
    pub(crate) fn linearize_slice(&self, given: &Slice<'_>) -> PyResult<(Vec<f64>, Vec<f64>)> {
        let own = &*self.simulator;
        let (n, nu) = (own.n_tangent(), own.nu());
        let mut a = vec![0.0; given.count * n * n];
        let mut b = vec![0.0; given.count * n * nu];
        let mut write = |k: usize, linear: &Linearization| {
            write_matrix(&linear.a, &mut a[k * n * n..(k + 1) * n * n]);
            write_matrix(&linear.b, &mut b[k * n * nu..(k + 1) * n * nu]);
        };
        match given.count {
            0 => {}
            1 => self.with_memory_of(&given.one(), |memory| {
                let new = || (LinearizeScratch::new(own), Linearization::zeros(own));
                let (scratch, linear) = memory.linear.get_or_insert_with(new);
                own.linearize_into(&memory.state, &memory.u, scratch, linear);
                write(0, linear);
            })?,
            _ => {
                let all = self.on_slice(given, |batch, states| batch.linearize(states, given.u))?;
                let rows = all.iter().enumerate();
                rows.for_each(|(k, linear)| write(k, linear));
            }
        }
        Ok((a, b))
    }

    /// The numbers (q, v) of all states of rollouts, of which those past the batch mean nothing.
    pub(crate) fn rollout_slice(&self, start: &Slice<'_>, steps: usize) -> PyResult<Vec<f64>> {
        let states = self.slice_states(start)?;
        let inputs = Inputs::Given {
            numbers: start.u,
            shared: false,
        };
        Python::attach(|py| match states.as_slice() {
            [] => Ok(Vec::new()),
            [one] => {
                let roll = |control: &mut Control<'_>| self.simulator.rollout(one, steps, control);
                let nu = self.simulator.nu();
                Ok(roll_with_inputs(py, &inputs, nu, steps, None, roll)?.states)
            }
            all => {
                let batch = self.take_batch(py, all.len(), None)?;
                let out = self.roll_batch(py, batch, all, steps, &inputs, None)?;
                Ok(out.states)
            }
        })
    }

    /// Runs work on the memory for batches and the states of a slice, on the pool.
    fn on_slice<R: Send>(
        &self,
        given: &Slice<'_>,
        work: impl FnOnce(&mut BatchSimulator, &[State]) -> R + Send,
    ) -> PyResult<R> {
        check_finite("u", given.u)?;
        let states = self.slice_states(given)?;
        let (pool, mut batch) = (pool()?, self.kept_batch(given.count)?);
        let out = guarded(|| pool.install(|| work(&mut batch.simulator, &states)))?;
        self.put_batch(batch);
        Ok(out)
    }

    fn slice_states(&self, given: &Slice<'_>) -> PyResult<Vec<State>> {
        let (nq, nv, ..) = self.sizes();
        let row = |k: usize| {
            let (q, v) = (&given.q[k * nq..][..nq], &given.v[k * nv..][..nv]);
            let state = State::new(q, v);
            state.check(self.simulator.model()).or_raise()?;
            Ok(state)
        };
        (0..given.count).map(row).collect()
    }
}

impl Slice<'_> {
    fn one(&self) -> One<'_> {
        One {
            q: self.q,
            v: self.v,
            u: Some(self.u),
            contact: None,
        }
    }
}
