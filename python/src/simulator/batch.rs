//! Rollouts of batches.

use dualbody::sim::{BatchStates, RolloutStatus};

use super::handle::Batch;
use super::single::SHORT;
use super::step::write_states;
use super::trajectories::{End, Trajectories};
use crate::prelude::*;
use crate::threads::{Watch, on_pool_watched};

impl PySimulator {
    /// Rollouts with inputs that are known, a row for each trajectory; zero without them.
    pub(super) fn roll_batch(
        &self,
        py: Python<'_>,
        mut batch: Batch,
        initial: &[State],
        steps: usize,
        inputs: Option<View<'_>>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Trajectories> {
        let (count, nu) = (initial.len(), self.simulator.nu());
        let short = count * steps < SHORT;
        let run = move |watch: Option<&Watch>| {
            let rollout = batch.simulator.rollout(initial, steps, |moment, _, u| {
                if let Some(watch) = watch {
                    watch.step();
                }
                if let Some(inputs) = inputs {
                    for (j, u) in u.iter_mut().enumerate() {
                        *u = moment.gather(|i| inputs.row(i)[moment.step * nu + j]);
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
        let end = |i| End {
            status: rollout.status(i),
            failure: rollout.solver_failure(i),
        };
        let ends: Vec<End> = (0..count).map(end).collect();
        let lengths: Vec<usize> = (0..count).map(|i| rollout.n_states(i)).collect();
        let mut states = rollout.into_numbers();
        let width = initial[0].len();
        for (i, &n) in lengths.iter().enumerate().filter(|&(_, &n)| n <= steps) {
            let start = i * (steps + 1) * width;
            states[start + n * width..start + (steps + 1) * width].fill(f64::NAN);
        }
        let padded = count.div_ceil(WIDTH) * WIDTH;
        Ok(Trajectories::new(states, padded, ends.into_iter()))
    }

    /// Rollouts whose inputs a function of Python gives; returns the inputs too.
    pub(super) fn roll_batch_controlled(
        &self,
        py: Python<'_>,
        mut batch: Batch,
        initial: &[State],
        shape: &[usize],
        steps: usize,
        control: &Bound<'_, PyAny>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<(Trajectories, Vec<f64>)> {
        let (nq, nv, nu, nc) = self.sizes();
        let mut now = on_pool(py, || batch.simulator.states(initial))?;
        let mut record = Record::new(initial, steps, nu);
        let array = |n: usize| empty(py, &[shape, &[n]].concat());
        for k in 0..=steps {
            let arrays = [array(nq), array(nv), array(nc)];
            write_states(&now, &arrays);
            record.add_states(k, &now, &arrays);
            if k == steps {
                break;
            }
            let [q, v, _] = arrays;
            let u = read_inputs_of(shape, nu, &control.call1((k, q, v))?)?;
            record.add_inputs(k, &u);
            (batch, now) = on_pool(py, move || {
                batch.simulator.step(&mut now, &u);
                (batch, now)
            })?;
            progress.map_or(Ok(()), |f| f.call1((k + 1,)).map(|_| ()))?;
        }
        self.put_batch(batch);
        let end = |i| End {
            status: now.status(i),
            failure: now.solver_failure(i),
        };
        let count = initial.len();
        let out = Trajectories::new(record.states, count, (0..count).map(end));
        Ok((out, record.inputs))
    }
}

/// The inputs that a control returned: a row for each state, or one for all.
fn read_inputs_of(shape: &[usize], nu: usize, given: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let u = Rows::read(&argument("the control's input", given, &[nu]))?;
    if !u.batch().is_empty() && u.batch() != shape {
        refuse!(
            "the control's input is a batch of shape {:?}, expected {shape:?}",
            u.batch()
        );
    }
    let (count, view) = (shape.iter().product(), u.view());
    let rows = (0..count).flat_map(|i| view.row(i));
    Ok(rows.copied().collect())
}

/// States of a rollout, trajectory after trajectory. Steps that a trajectory did not reach are not numbers.
struct Record {
    steps: usize,
    /// Numbers of a state, and of an input.
    width: usize,
    nu: usize,
    states: Vec<f64>,
    inputs: Vec<f64>,
}

impl Record {
    fn new(initial: &[State], steps: usize, nu: usize) -> Self {
        let (count, width) = (initial.len(), initial[0].len());
        Self {
            steps,
            width,
            nu,
            states: vec![f64::NAN; count * (steps + 1) * width],
            inputs: vec![f64::NAN; count * steps * nu],
        }
    }

    /// Adds the states of a step, from arrays of their parts, except those that have stopped.
    fn add_states(&mut self, step: usize, now: &BatchStates, parts: &[Array<'_>]) {
        for i in 0..now.len() {
            if !matches!(now.status(i), RolloutStatus::Completed) {
                continue;
            }
            let mut at = (i * (self.steps + 1) + step) * self.width;
            for array in parts {
                let all = numbers_mut(array);
                let n = all.len() / now.len();
                self.states[at..at + n].copy_from_slice(&all[i * n..(i + 1) * n]);
                at += n;
            }
        }
    }

    /// Adds the inputs of a step.
    fn add_inputs(&mut self, step: usize, u: &[f64]) {
        for (i, own) in u.chunks(self.nu.max(1)).enumerate() {
            let start = (i * self.steps + step) * self.nu;
            self.inputs[start..start + self.nu].copy_from_slice(own);
        }
    }
}
