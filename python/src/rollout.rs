//! Rollouts of one state and of batches, with inputs that are given or that a function of Python gives.

use std::cell::Cell;

use dualbody::State;
use dualbody::sim::{Rollout, RolloutStatus, SolverFailure};
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::arrays::{Rows, WIDTH, argument, empty, numbers_mut, read_vector};
use crate::errors::{guarded, value_error};
use crate::simulator::{Batch, PySimulator, row, write_states};
use crate::threads::{Watch, on_pool, on_pool_watched};

/// Steps of fewer states than this are taken without releasing the interpreter lock.
const SHORT: usize = 1000;

pub(crate) type Status = (&'static str, Option<usize>);

fn status_of(status: RolloutStatus) -> Status {
    match status {
        RolloutStatus::NonFiniteInput { step } => ("non_finite_input", Some(step)),
        RolloutStatus::Diverged { step } => ("diverged", Some(step)),
        _ => ("completed", None),
    }
}

fn failure_of(failure: Option<SolverFailure>) -> Option<(usize, String)> {
    failure.map(|failure| (failure.step, format!("{:?}", failure.status)))
}

/// What a rollout gives: numbers of the states, inputs, status and failure of the solver of each trajectory.
pub(crate) struct Trajectories {
    /// (trajectories, steps + 1, width) numbers.
    pub(crate) states: Vec<f64>,
    /// Trajectories for which there is memory; those past the batch mean nothing.
    pub(crate) padded: usize,
    pub(crate) statuses: Vec<Status>,
    pub(crate) failures: Vec<Option<(usize, String)>>,
}

/// Inputs of a rollout.
pub(crate) enum Inputs<'a> {
    None,
    /// Shared by all trajectories, or one block (steps × nu) each.
    Given {
        numbers: &'a [f64],
        shared: bool,
    },
}

impl Inputs<'_> {
    fn at(&self, i: usize, k: usize, j: usize, steps: usize, nu: usize) -> f64 {
        match self {
            Self::None => 0.0,
            Self::Given { numbers, shared } => {
                let i = if *shared { 0 } else { i };
                numbers[(i * steps + k) * nu + j]
            }
        }
    }
}

/// Copies a trajectory of the library into rows; what it did not reach is not a number.
fn rows_of(rollout: &Rollout, steps: usize) -> Vec<f64> {
    let width = rollout.states[0].len();
    let mut out = vec![f64::NAN; (steps + 1) * width];
    for (row, state) in out.chunks_mut(width.max(1)).zip(&rollout.states) {
        state.copy_to_slice(row);
    }
    out
}

impl PySimulator {
    pub(crate) fn roll_one(
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
            single(&rollout, steps)
        };
        match steps < SHORT {
            true => guarded(|| run(None)),
            false => on_pool_watched(py, progress, |watch| run(Some(watch))),
        }
    }

    /// A rollout whose inputs a function of Python gives; returns the inputs too.
    pub(crate) fn roll_one_controlled(
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
            None => Ok((single(&rollout, steps), inputs)),
        }
    }

    pub(crate) fn roll_batch(
        &self,
        py: Python<'_>,
        mut batch: Batch,
        initial: &[State],
        steps: usize,
        inputs: &Inputs<'_>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Trajectories> {
        let (count, nu) = (initial.len(), self.simulator.nu());
        let short = count * steps < SHORT;
        let run = move |watch: Option<&Watch>| {
            let rollout = batch.simulator.rollout(initial, steps, |moment, _, u| {
                if let Some(watch) = watch {
                    watch.add(1);
                    if watch.must_stop() {
                        return u.fill(dualbody::Lanes([f64::NAN; WIDTH]));
                    }
                }
                if !matches!(inputs, Inputs::None) {
                    for (j, u) in u.iter_mut().enumerate() {
                        *u = moment.gather(|i| inputs.at(i, moment.step, j, steps, nu));
                    }
                }
            });
            (rollout, batch)
        };
        let (rollout, batch) = match short {
            true => on_pool(py, || run(None))?,
            false => on_pool_watched(py, progress, |watch| run(Some(watch)))?,
        };
        self.put_batch(batch);
        let statuses: Vec<_> = (0..count).map(|i| rollout.status(i)).collect();
        let failures = (0..count)
            .map(|i| failure_of(rollout.solver_failure(i)))
            .collect();
        let lengths: Vec<usize> = (0..count).map(|i| rollout.n_states(i)).collect();
        let mut states = rollout.into_numbers();
        let width = initial[0].len();
        for (i, &n) in lengths.iter().enumerate().filter(|&(_, &n)| n <= steps) {
            let start = i * (steps + 1) * width;
            states[start + n * width..start + (steps + 1) * width].fill(f64::NAN);
        }
        Ok(Trajectories {
            states,
            padded: count.div_ceil(WIDTH) * WIDTH,
            statuses: statuses.into_iter().map(status_of).collect(),
            failures,
        })
    }

    pub(crate) fn roll_batch_controlled(
        &self,
        py: Python<'_>,
        mut batch: Batch,
        initial: &[State],
        shape: &[usize],
        steps: usize,
        control: &Bound<'_, PyAny>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<(Trajectories, Vec<f64>)> {
        let (count, (nq, nv, nu, nc)) = (initial.len(), self.sizes());
        let width = nq + nv + nc;
        let mut now = on_pool(py, || batch.simulator.states(initial))?;
        let mut states = vec![f64::NAN; count * (steps + 1) * width];
        let mut inputs = vec![f64::NAN; count * steps * nu];
        let array = |n: usize| empty(py, &[shape, &[n]].concat());
        for k in 0..=steps {
            let out = [array(nq), array(nv), array(nc)];
            write_states(&now, &out);
            for i in 0..count {
                let going = matches!(now.status(i), RolloutStatus::Completed);
                if !going {
                    continue;
                }
                let mut at = (i * (steps + 1) + k) * width;
                for (array, n) in out.iter().zip([nq, nv, nc]) {
                    states[at..at + n].copy_from_slice(&numbers_mut(array)[i * n..(i + 1) * n]);
                    at += n;
                }
            }
            if k == steps {
                break;
            }
            let [q, v, _] = out;
            let given = control.call1((k, q, v))?;
            let u = Rows::read(&argument("the control's input", &given, &[nu]))?;
            if !u.batch().is_empty() && u.batch() != shape {
                return Err(value_error(format_args!(
                    "the control's input is a batch of shape {:?}, expected {shape:?}",
                    u.batch()
                )));
            }
            let u: Vec<f64> = (0..count)
                .flat_map(|i| row(&u, i, nu).iter().copied())
                .collect();
            for i in 0..count {
                let start = (i * steps + k) * nu;
                inputs[start..start + nu].copy_from_slice(&u[i * nu..(i + 1) * nu]);
            }
            (batch, now) = on_pool(py, move || {
                batch.simulator.step(&mut now, &u);
                (batch, now)
            })?;
            progress.map_or(Ok(()), |f| f.call1((k + 1,)).map(|_| ()))?;
        }
        self.put_batch(batch);
        Ok((
            Trajectories {
                states,
                padded: count,
                statuses: (0..count).map(|i| status_of(now.status(i))).collect(),
                failures: (0..count)
                    .map(|i| failure_of(now.solver_failure(i)))
                    .collect(),
            },
            inputs,
        ))
    }
}

fn single(rollout: &Rollout, steps: usize) -> Trajectories {
    Trajectories {
        states: rows_of(rollout, steps),
        padded: 1,
        statuses: vec![status_of(rollout.status)],
        failures: vec![failure_of(rollout.solver_failure)],
    }
}

/// Reads the input that a control returned: a vector, or a number if there is one input.
fn read_input(given: &Bound<'_, PyAny>, nu: usize, u: &mut [f64]) -> PyResult<()> {
    if nu == 1
        && let Ok(x) = given.extract::<f64>()
    {
        u[0] = x;
        return Ok(());
    }
    u.copy_from_slice(&read_vector("the control's input", given, Some(nu))?);
    Ok(())
}

/// Reads inputs (…, steps, nu), and finds the number of steps.
pub(crate) fn read_inputs<'py>(
    inputs: Option<&Bound<'py, PyAny>>,
    steps: Option<usize>,
    nu: usize,
) -> PyResult<(Option<Rows<'py>>, usize)> {
    let Some(inputs) = inputs else {
        let steps = steps.ok_or_else(|| value_error("steps is missing"))?;
        return Ok((None, steps));
    };
    let steps = match steps {
        Some(steps) => steps,
        None => {
            let shape: Vec<usize> = crate::arrays::numbers("inputs", inputs)?
                .getattr("shape")?
                .extract()?;
            let axes = shape.len().checked_sub(2).map(|k| shape[k]);
            axes.ok_or_else(|| {
                value_error(format_args!(
                    "inputs has the shape {shape:?}, expected (…, steps, {nu})"
                ))
            })?
        }
    };
    Ok((
        Some(Rows::read(&argument("inputs", inputs, &[steps, nu]))?),
        steps,
    ))
}
