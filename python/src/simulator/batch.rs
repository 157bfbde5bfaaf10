//! Rollouts of batches.

use dualbody::State;
use dualbody::sim::RolloutStatus;
use pyo3::prelude::*;

use super::given::row;
use super::handle::PySimulator;
use super::inputs::Inputs;
use super::memory::Batch;
use super::single::SHORT;
use super::step::write_states;
use super::trajectories::{Trajectories, failure_of, status_of};
use crate::arrays::{Rows, WIDTH, argument, empty, numbers_mut};
use crate::errors::value_error;
use crate::threads::{Watch, on_pool, on_pool_watched};

impl PySimulator {
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
