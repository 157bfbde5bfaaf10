//! Working memory of functions for one robot, kept by each thread.

use dualbody::Model;
use dualbody::sim::BatchScalar;
use dualbody_python_table::{Lifted, Memory as Of};

/// Working memory that a thread keeps, for as many models or simulators.
const KEPT: usize = 8;

/// Finds the memory that is meant among what a thread keeps; it is made at the first call, and the oldest goes if there are too many.
pub(crate) fn find_or_make<M, E>(
    all: &mut Vec<M>,
    is_meant: impl Fn(&M) -> bool,
    make: impl FnOnce() -> Result<M, E>,
) -> Result<&mut M, E> {
    let at = match all.iter().position(is_meant) {
        Some(at) => at,
        None => {
            let new = make()?;
            if all.len() == KEPT {
                all.remove(0);
            }
            all.push(new);
            all.len() - 1
        }
    };
    Ok(&mut all[at])
}

/// Working memory for a robot.
pub(crate) struct Memory {
    id: u64,
    pub(crate) one: Of<f64>,
    pub(crate) wide: Of<BatchScalar>,
    /// The robot on dual numbers.
    pub(crate) dual: Option<Lifted>,
}

impl Memory {
    pub(crate) fn new(model: &Model, id: u64) -> Self {
        Self {
            id,
            one: Of::new(model),
            wide: Of::new(model),
            dual: None,
        }
    }

    pub(crate) fn id(&self) -> u64 {
        self.id
    }
}
