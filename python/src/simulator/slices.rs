//! Steps, Jacobians and rollouts of sequences that are not arrays of NumPy; the interpreter lock is not needed for steps and Jacobians.

use dualbody::linearize::LinearizeScratch;
use dualbody::sim::{BatchSimulator, RolloutStatus};
use dualbody::{Linearization, State};
use pyo3::prelude::*;

use super::handle::PySimulator;
use super::inputs::Inputs;
use super::memory::One;
use super::single::{Control, roll_with_inputs};
use super::step::{diverged, write_parts, write_row};
use crate::errors::guarded;
use crate::threads::pool;

/// States and inputs, row after row.
pub(crate) struct Slice<'a> {
    pub(crate) q: &'a [f64],
    pub(crate) v: &'a [f64],
    pub(crate) u: &'a [f64],
    pub(crate) contact: Option<&'a [f64]>,
    pub(crate) count: usize,
}

impl PySimulator {
    /// The next q, v, and the next state of contact if there is room for it. The states are checked.
    pub(crate) fn step_slice(&self, given: &Slice<'_>, out: &mut [&mut [f64]]) -> PyResult<()> {
        if given.count == 1 {
            return self.step_slice_of_one(given, out);
        }
        if given.count == 0 {
            return Ok(());
        }
        let states: Vec<State> = (0..given.count).map(|k| self.state_of(given, k)).collect();
        let next = self.on_slice(given.count, |batch| {
            let mut all = batch.states(&states);
            batch.step(&mut all, given.u);
            all
        })?;
        let stopped = |i: &usize| !matches!(next.status(*i), RolloutStatus::Completed);
        if let Some(i) = (0..given.count).find(stopped) {
            return Err(diverged(Some(i)));
        }
        write_parts(&next, out);
        Ok(())
    }

    fn state_of(&self, given: &Slice<'_>, k: usize) -> State {
        let (nq, nv, _, nc) = self.sizes();
        let state = self
            .simulator
            .state(&given.q[k * nq..][..nq], &given.v[k * nv..][..nv]);
        match given.contact {
            Some(all) => self.with_beside(state, &all[k * nc..][..nc]),
            None => state,
        }
    }

    fn step_slice_of_one(&self, given: &Slice<'_>, out: &mut [&mut [f64]]) -> PyResult<()> {
        let one = One {
            q: given.q,
            v: given.v,
            u: Some(given.u),
            contact: given.contact,
        };
        let is_finite = self.with_memory_of(&one, |memory| {
            if one.contact.is_none() {
                memory.state.contact.fill(0.0);
                memory.state.activation.fill(0.0);
            }
            let next = &mut memory.next;
            let (state, scratch) = (&memory.state, &mut memory.scratch);
            self.simulator.step_into(state, &memory.u, scratch, next);
            write_row(next, 0, out, |&x| x);
            next.is_finite()
        })?;
        match is_finite {
            true => Ok(()),
            false => Err(diverged(None)),
        }
    }

    /// Jacobians of the steps of some states.
    pub(crate) fn linearize_states(
        &self,
        states: &[State],
        inputs: &[f64],
    ) -> PyResult<Vec<Linearization>> {
        let own = &*self.simulator;
        match states {
            [] => Ok(Vec::new()),
            [state] => guarded(|| {
                let mut out = Linearization::zeros(own);
                own.linearize_into(state, inputs, &mut LinearizeScratch::new(own), &mut out);
                vec![out]
            }),
            _ => self.on_slice(states.len(), |batch| batch.linearize(states, inputs)),
        }
    }

    /// All q, v, and states of contact if there is room for them, of rollouts.
    pub(crate) fn rollout_slice(
        &self,
        states: &[State],
        inputs: &[f64],
        steps: usize,
        out: &mut [&mut [f64]],
    ) -> PyResult<()> {
        let given = Inputs::Given {
            numbers: inputs,
            shared: false,
        };
        let (nq, nv, nu, nc) = self.sizes();
        let all = Python::attach(|py| -> PyResult<Vec<f64>> {
            match states {
                [] => Ok(Vec::new()),
                [one] => {
                    let roll =
                        |control: &mut Control<'_>| self.simulator.rollout(one, steps, control);
                    Ok(roll_with_inputs(py, &given, nu, steps, None, roll)?.states)
                }
                all => {
                    let batch = self.take_batch(py, all.len(), None)?;
                    Ok(self.roll_batch(py, batch, all, steps, &given, None)?.states)
                }
            }
        })?;
        let rows = all
            .chunks((nq + nv + nc).max(1))
            .take(states.len() * (steps + 1));
        for (k, row) in rows.enumerate() {
            let parts = [&row[..nq], &row[nq..nq + nv], &row[nq + nv..]];
            for (out, x) in out.iter_mut().zip(parts) {
                out[k * x.len()..(k + 1) * x.len()].copy_from_slice(x);
            }
        }
        Ok(())
    }

    /// Runs work on the memory for batches of a length, on the pool.
    fn on_slice<R: Send>(
        &self,
        count: usize,
        work: impl FnOnce(&mut BatchSimulator) -> R + Send,
    ) -> PyResult<R> {
        let (pool, mut batch) = (pool()?, self.kept_batch(count)?);
        let out = guarded(|| pool.install(|| work(&mut batch.simulator)))?;
        self.put_batch(batch);
        Ok(out)
    }
}
