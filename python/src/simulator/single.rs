//! Rollouts of one state.

use std::cell::Cell;

use dualbody::State;
use numpy::PyArray1;
use pyo3::prelude::*;

use super::handle::PySimulator;
use super::inputs::{Inputs, read_input};
use super::trajectories::Trajectories;
use crate::errors::guarded;
use crate::threads::{Watch, on_pool_watched};

/// Steps of fewer states than this are taken without releasing the interpreter lock.
pub(super) const SHORT: usize = 1000;

impl PySimulator {
    pub(super) fn roll_one(
        &self,
        py: Python<'_>,
        initial: &State,
        steps: usize,
        inputs: &Inputs<'_>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Trajectories> {
        let nu = self.simulator.nu();
        let run = |watch: Option<&Watch>| {
            let mut k = 0;
            let rollout = self.simulator.rollout(initial, steps, |_, _, u| {
                for (j, u) in u.iter_mut().enumerate() {
                    *u = inputs.at(0, k, j, steps, nu);
                }
                k += 1;
                if let Some(watch) = watch {
                    watch.add(1);
                    if watch.must_stop()
                        && let Some(u) = u.first_mut()
                    {
                        *u = f64::NAN;
                    }
                }
            });
            Trajectories::single(&rollout, steps)
        };
        match steps < SHORT {
            true => guarded(|| run(None)),
            false => on_pool_watched(py, progress, |watch| run(Some(watch))),
        }
    }

    /// A rollout whose inputs a function of Python gives; returns the inputs too.
    pub(super) fn roll_one_controlled(
        &self,
        py: Python<'_>,
        initial: &State,
        steps: usize,
        control: &Bound<'_, PyAny>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<(Trajectories, Vec<f64>)> {
        let (nu, step) = (self.simulator.nu(), Cell::new(0));
        let mut inputs = vec![f64::NAN; steps * nu];
        let mut raised = None;
        let rollout = guarded(|| {
            self.simulator.rollout(initial, steps, |_, state, u| {
                let k = step.replace(step.get() + 1);
                let (q, v) = (state.q.as_slice(), state.v.as_slice());
                let arrays = (PyArray1::from_slice(py, q), PyArray1::from_slice(py, v));
                let given = control.call1((k, arrays.0, arrays.1));
                let given = given.and_then(|given| read_input(&given, nu, u));
                let shown = progress.map_or(Ok(()), |f| f.call1((k + 1,)).map(|_| ()));
                match given.and(shown) {
                    Ok(()) => inputs[k * nu..(k + 1) * nu].copy_from_slice(u),
                    Err(error) => {
                        raised.get_or_insert(error);
                        u.fill(f64::NAN);
                    }
                }
            })
        })?;
        match raised {
            Some(error) => Err(error),
            None => Ok((Trajectories::single(&rollout, steps), inputs)),
        }
    }
}
