//! Rollouts of one state, by whatever takes its steps.

use std::cell::Cell;
use std::panic::resume_unwind;

use dualbody::sim::Rollout;

use super::given::read_input;
use super::trajectories::Trajectories;
use crate::prelude::*;
use crate::threads::{Watch, on_pool_watched};

/// A function that writes the input of a time and a state.
pub(super) type Control<'a> = dyn FnMut(f64, &State, &mut [f64]) + 'a;

/// Steps of fewer states than this are taken without releasing the interpreter lock.
pub(super) const SHORT: usize = 1000;

/// A rollout with inputs that are known, all in one row; zero without them.
///
/// * `roll` – takes the steps, and asks what it is given for their inputs
pub(super) fn roll_with_inputs(
    py: Python<'_>,
    inputs: Option<View<'_>>,
    nu: usize,
    steps: usize,
    progress: Option<&Bound<'_, PyAny>>,
    roll: impl FnOnce(&mut Control<'_>) -> Rollout + Send,
) -> PyResult<Trajectories> {
    let run = |watch: Option<&Watch>| {
        let mut k = 0;
        let rollout = roll(&mut |_, _, u| {
            match inputs {
                Some(inputs) => u.copy_from_slice(&inputs.row(0)[k * nu..(k + 1) * nu]),
                None => u.fill(0.0),
            }
            k += 1;
            if let Some(watch) = watch {
                watch.step();
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
///
/// * `roll` – takes the steps, and asks what it is given for their inputs
pub(super) fn roll_controlled(
    control: &Bound<'_, PyAny>,
    nu: usize,
    steps: usize,
    progress: Option<&Bound<'_, PyAny>>,
    roll: impl FnOnce(&mut Control<'_>) -> Rollout,
) -> PyResult<(Trajectories, Vec<f64>)> {
    let (py, step) = (control.py(), Cell::new(0));
    let mut inputs = vec![f64::NAN; steps * nu];
    let mut raised = None;
    let mut ask = |_, state: &State, u: &mut [f64]| {
        let k = step.replace(step.get() + 1);
        let (q, v) = (state.q.as_slice(), state.v.as_slice());
        let arrays = (PyArray1::from_slice(py, q), PyArray1::from_slice(py, v));
        let given = control.call1((k, arrays.0, arrays.1));
        let given = given.and_then(|given| read_input(&given, nu, u));
        let shown = progress.map_or(Ok(()), |f| f.call1((k + 1,)).map(|_| ()));
        match given.and(shown) {
            Ok(()) => inputs[k * nu..(k + 1) * nu].copy_from_slice(u),
            Err(error) => {
                raised = Some(error);
                resume_unwind(Box::new("an exception")); // also where there is no input to say it by
            }
        }
    };
    let rollout = guarded(|| roll(&mut ask));
    match raised {
        Some(error) => Err(error),
        None => Ok((Trajectories::single(&rollout?, steps), inputs)),
    }
}
