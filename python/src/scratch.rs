//! Working memory, which each thread keeps.

use std::any::Any;
use std::cell::RefCell;

use dualbody::sim::BatchScalar;
use dualbody_python_table::{Lifted, Memory as Of};

use crate::prelude::*;

/// How many memories a thread keeps, of all kinds together.
const KEPT: usize = 16;

thread_local! {
    /// Memories with the numbers of what they are for, those used last at the end.
    static MEMORIES: RefCell<Vec<(u64, Box<dyn Any>)>> = const { RefCell::new(Vec::new()) };
}

/// Runs work with this thread's memory of a type for a robot, a simulator or another object with a number of its own. It is made at the first call.
///
/// The work may ask for other memory: its own is not in the list meanwhile, and is dropped if the work panics.
pub(crate) fn with_kept<M: 'static, R>(
    id: u64,
    make: impl FnOnce() -> M,
    work: impl FnOnce(&mut M) -> R,
) -> R {
    let kept = MEMORIES.with_borrow_mut(|all| {
        let is_meant = |(own, memory): &(u64, Box<dyn Any>)| *own == id && memory.is::<M>();
        all.iter().rposition(is_meant).map(|at| all.remove(at).1)
    });
    let kept = kept.and_then(|memory| memory.downcast::<M>().ok());
    let mut memory = kept.unwrap_or_else(|| Box::new(make()));
    let out = work(&mut memory);
    MEMORIES.with_borrow_mut(|all| {
        if all.len() == KEPT {
            all.remove(0);
        }
        all.push((id, memory));
    });
    out
}

/// Working memory of functions of the table for a robot.
pub(crate) struct Memory {
    pub(crate) one: Of<f64>,
    pub(crate) wide: Of<BatchScalar>,
    /// The robot on dual numbers.
    pub(crate) dual: Option<Lifted>,
}

impl Memory {
    pub(crate) fn new(model: &Model) -> Self {
        Self {
            one: Of::new(model),
            wide: Of::new(model),
            dual: None,
        }
    }
}
