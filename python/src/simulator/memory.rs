//! Working memory of steps.

use std::cell::RefCell;

use dualbody::linearize::LinearizeScratch;
use dualbody::sim::{BatchSimulator, StepScratch};
use dualbody::{Linearization, Model, Simulator, State};
use pyo3::prelude::*;

use super::given::{Given, check_finite, row, set_beside};
use super::handle::{Batch, PySimulator};
use crate::arrays::WIDTH;
use crate::errors::{OrRaise, guarded, value_error};
use crate::model::PyModel;
use crate::scratch::find_or_make;
use crate::threads::{on_pool, pool};

/// Working memory of a thread for a simulator.
pub(super) struct StepMemory {
    pub(super) id: u64,
    pub(super) scratch: StepScratch<f64>,
    pub(super) state: State,
    pub(super) next: State,
    pub(super) u: Vec<f64>,
    pub(super) linear: Option<(LinearizeScratch, Linearization)>,
}

thread_local! {
    static MEMORIES: RefCell<Vec<StepMemory>> = const { RefCell::new(Vec::new()) };
}

/// Numbers of one state, with its input.
pub(super) struct One<'a> {
    pub(super) q: &'a [f64],
    pub(super) v: &'a [f64],
    pub(super) u: Option<&'a [f64]>,
    pub(super) contact: Option<&'a [f64]>,
}

impl PySimulator {
    /// Runs work with this thread's memory for one state, in which state and input are set.
    pub(super) fn with_memory<R>(
        &self,
        given: &Given<'_>,
        work: impl FnOnce(&mut StepMemory) -> R,
    ) -> PyResult<R> {
        let (nq, nv, nu, nc) = self.sizes();
        let given = One {
            q: row(&given.q, 0, nq),
            v: row(&given.v, 0, nv),
            u: given.u.as_ref().map(|u| row(u, 0, nu)),
            contact: given.contact.as_ref().map(|contact| row(contact, 0, nc)),
        };
        self.with_memory_of(&given, work)
    }

    /// [`Self::with_memory`] for numbers.
    pub(super) fn with_memory_of<R>(
        &self,
        given: &One<'_>,
        work: impl FnOnce(&mut StepMemory) -> R,
    ) -> PyResult<R> {
        MEMORIES.with_borrow_mut(|all| {
            let is_meant = |memory: &StepMemory| memory.id == self.id;
            let memory = find_or_make(all, is_meant, || guarded(|| self.memory()))?;
            let state = &mut memory.state;
            state.q.as_mut_slice().copy_from_slice(given.q);
            state.v.as_mut_slice().copy_from_slice(given.v);
            if let Some(contact) = given.contact {
                set_beside(state, contact);
            }
            match given.u {
                Some(u) => memory.u.copy_from_slice(u),
                None => memory.u.fill(0.0),
            }
            check_finite("u", &memory.u)?;
            memory.state.check(self.simulator.model()).or_raise()?;
            guarded(|| work(memory))
        })
    }

    pub(super) fn memory(&self) -> StepMemory {
        let state = self.simulator.neutral_state();
        StepMemory {
            id: self.id,
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

    /// Runs work with the memory for batches of a length, on the pool; each state has a robot of its own if there are `models`.
    pub(super) fn on_batch<R: Send>(
        &self,
        py: Python<'_>,
        length: usize,
        models: Option<&[Py<PyModel>]>,
        work: impl FnOnce(&mut BatchSimulator) -> R + Send,
    ) -> PyResult<R> {
        let mut batch = self.take_batch(py, length, models)?;
        let (out, batch) = on_pool(py, move || (work(&mut batch.simulator), batch))?;
        self.put_batch(batch);
        Ok(out)
    }

    /// The memory for batches of a length, each state with a robot of its own if there are `models`.
    pub(crate) fn take_batch(
        &self,
        py: Python<'_>,
        length: usize,
        models: Option<&[Py<PyModel>]>,
    ) -> PyResult<Batch> {
        if let Some(models) = models {
            check_count(models, length)?;
            let models: Vec<Model> = models.iter().map(|m| (*m.get().model).clone()).collect();
            let made = on_pool(py, || BatchSimulator::of_variants(&self.simulator, models))?;
            let simulator = made.or_raise()?.with_threads(threads_for(length)?);
            return Ok(Batch {
                simulator,
                states: None,
                is_kept: false,
            });
        }
        py.detach(|| self.kept_batch(length))
    }

    /// The memory for batches of a length; the interpreter lock is not needed.
    pub(super) fn kept_batch(&self, length: usize) -> PyResult<Batch> {
        let threads = threads_for(length)?;
        let kept = self
            .batch
            .try_lock()
            .ok()
            .and_then(|mut batch| batch.take());
        let fits =
            |batch: &Batch| batch.simulator.len() == length && batch.simulator.threads() == threads;
        if let Some(batch) = kept.filter(fits) {
            return Ok(batch);
        }
        let (pool, simulator) = (pool()?, (*self.simulator).clone());
        let make = || BatchSimulator::new(simulator, length).with_threads(threads);
        Ok(Batch {
            simulator: guarded(|| pool.install(make))?,
            states: None,
            is_kept: true,
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
    match batch.is_empty() && has_models {
        true => Err(value_error(
            "models are for a batch, and there is one state",
        )),
        false => Ok(()),
    }
}

fn check_count(models: &[Py<PyModel>], length: usize) -> PyResult<()> {
    match models.len() {
        given if given == length => Ok(()),
        given => Err(value_error(format_args!(
            "{given} models for {length} states"
        ))),
    }
}

/// Threads for a batch of a length.
pub(super) fn threads_for(length: usize) -> PyResult<usize> {
    let all = pool()?.current_num_threads();
    Ok(all.min(length.div_ceil(WIDTH)).max(1))
}
