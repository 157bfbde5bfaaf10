//! Working memory of steps.

use dualbody::Linearization;
use dualbody::linearize::LinearizeScratch;
use dualbody::sim::{BatchSimulator, StepScratch};
use rayon::prelude::*;

use super::given::{Given, States, check_finite};
use super::handle::Batch;
use crate::prelude::*;
use crate::threads::{FEW, install, pool};

/// Working memory of a thread for a simulator.
pub(crate) struct StepMemory {
    pub(super) scratch: StepScratch<f64>,
    pub(crate) state: State,
    pub(super) next: State,
    pub(crate) u: Vec<f64>,
    pub(super) linear: Option<(LinearizeScratch, Linearization)>,
}

impl PySimulator {
    /// Runs work with this thread's memory for one state, in which state and input are set.
    pub(crate) fn with_memory<'a, R>(
        &self,
        given: impl Into<States<'a>>,
        work: impl FnOnce(&mut StepMemory) -> R,
    ) -> PyResult<R> {
        self.with_memory_at(&given.into(), 0, work)
    }

    /// [`Self::with_memory`] for the k-th state.
    fn with_memory_at<R>(
        &self,
        given: &States<'_>,
        k: usize,
        work: impl FnOnce(&mut StepMemory) -> R,
    ) -> PyResult<R> {
        let with = |memory: &mut StepMemory| {
            self.read_state(given, k, &mut memory.state)?;
            match given.u {
                Some(u) => memory.u.copy_from_slice(u.row(k)),
                None => memory.u.fill(0.0),
            }
            check_finite("u", &memory.u).map_err(|error| given.named(k, error))?;
            Ok(work(memory))
        };
        guarded(|| with_kept(self.id, || self.memory(), with))?
    }

    /// A row of numbers for each state of a call, each written with memory in which state and input are set; many on the pool.
    pub(crate) fn rows<'py>(
        &self,
        py: Python<'py>,
        given: &Given<'py>,
        width: usize,
        out: Option<&Bound<'py, PyAny>>,
        write: impl Fn(usize, &mut StepMemory, &mut [f64]) + Send + Sync,
    ) -> PyResult<Array<'py>> {
        let shape = [given.batch.as_slice(), &[width]].concat();
        let array = match out {
            Some(out) => checked_output("out", out, &shape)?,
            None => empty(py, &shape),
        };
        let (states, count, width) = (States::from(given), given.count(), width.max(1));
        let one = |(k, row): (usize, &mut [f64])| {
            self.with_memory_at(&states, k, |memory| write(k, memory, row))
        };
        // The output may be an argument, which other states are still read from.
        let mut apart = match out.is_some() && count > 1 {
            true => vec![0.0; numbers_mut(&array).len()],
            false => Vec::new(),
        };
        let numbers = match apart.is_empty() {
            true => numbers_mut(&array),
            false => &mut apart,
        };
        if count < FEW {
            numbers.chunks_mut(width).enumerate().try_for_each(one)?;
        } else {
            let (pool, rows) = (pool()?, numbers.par_chunks_mut(width).enumerate());
            py.detach(|| install(&pool, || rows.try_for_each(one)))?;
        }
        if !apart.is_empty() {
            numbers_mut(&array).copy_from_slice(&apart);
        }
        Ok(array)
    }

    fn memory(&self) -> StepMemory {
        let state = self.simulator.neutral_state();
        StepMemory {
            scratch: StepScratch::new(&self.simulator),
            next: state.clone(),
            state,
            u: vec![0.0; self.simulator.nu()],
            linear: None,
        }
    }

    /// A simulator for each state of a batch, if there are models for them.
    pub(super) fn variants(
        &self,
        models: Option<&[Py<PyModel>]>,
        length: usize,
    ) -> PyResult<Option<Vec<Simulator>>> {
        let Some(models) = models else {
            return Ok(None);
        };
        check_count(models, length)?;
        let one = |model: &Py<PyModel>| self.simulator.with_model((*model.get().model).clone());
        let all: Result<Vec<_>, _> = guarded(|| models.iter().map(one).collect())?;
        all.or_raise().map(Some)
    }

    /// Runs work with the memory for batches of a length, on the pool; each state has a robot of its own if there are `models`. The interpreter lock is
    /// not needed.
    pub(super) fn on_batch<R: Send>(
        &self,
        length: usize,
        models: Option<&[Py<PyModel>]>,
        work: impl FnOnce(&mut Batch) -> R + Send,
    ) -> PyResult<R> {
        let (pool, mut batch) = (pool()?, self.take_batch(length, models)?);
        let out = guarded(|| install(&pool, || work(&mut batch)))?;
        self.put_batch(batch);
        Ok(out)
    }

    /// The memory for batches of a length, each state with a robot of its own if there are `models`; the interpreter lock is not needed.
    pub(crate) fn take_batch(
        &self,
        length: usize,
        models: Option<&[Py<PyModel>]>,
    ) -> PyResult<Batch> {
        let (pool, threads) = (pool()?, threads_for(length)?);
        let simulator = match models {
            Some(models) => {
                check_count(models, length)?;
                let models: Vec<Model> = models.iter().map(|m| (*m.get().model).clone()).collect();
                let make = || BatchSimulator::of_variants(&self.simulator, models);
                guarded(|| install(&pool, make))?.or_raise()?
            }
            None => {
                let kept = self.batch.try_lock().ok();
                let kept = kept.and_then(|mut batch| batch.take());
                let fits = |batch: &Batch| {
                    batch.simulator.len() == length && batch.simulator.threads() == threads
                };
                if let Some(batch) = kept.filter(fits) {
                    return Ok(batch);
                }
                let simulator = (*self.simulator).clone();
                guarded(|| install(&pool, || BatchSimulator::new(simulator, length)))?
            }
        };
        Ok(Batch {
            simulator: simulator.with_threads(threads),
            states: None,
            is_kept: models.is_none(),
        })
    }

    pub(crate) fn put_batch(&self, batch: Batch) {
        if batch.is_kept
            && let Ok(mut kept) = self.batch.try_lock()
        {
            *kept = Some(batch);
        }
    }
}

/// Refuses models for one state.
pub(super) fn check_batch(batch: &[usize], has_models: bool) -> PyResult<()> {
    let is_for_batch = !(batch.is_empty() && has_models);
    ensure!(
        is_for_batch,
        "models are for a batch, and there is one state"
    );
    Ok(())
}

fn check_count(models: &[Py<PyModel>], length: usize) -> PyResult<()> {
    let given = models.len();
    ensure!(given == length, "{given} models for {length} states");
    Ok(())
}

/// Threads for a batch of a length.
pub(super) fn threads_for(length: usize) -> PyResult<usize> {
    let all = pool()?.current_num_threads();
    Ok(all.min(length.div_ceil(WIDTH)).max(1))
}
