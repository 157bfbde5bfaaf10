//! On how many threads short work is done again and again.

use std::time::{Duration, Instant};

use crate::prelude::*;
use crate::threads::beside_pool;

/// Work that takes less time is done by the thread that asks for it: to wake another one takes as long.
const SHORT: Duration = Duration::from_micros(60);
/// How often the time is taken before it is believed.
const TRIALS: usize = 4;

/// Decides whether work that is repeated goes to threads of the pool as well. It is done on one thread first, and the shortest of some times is what it takes.
pub(super) struct Spread {
    trials: usize,
    shortest: Duration,
}

impl Spread {
    pub(super) fn new() -> Self {
        Self {
            trials: 0,
            shortest: Duration::MAX,
        }
    }

    /// Whether the work from now on goes to the pool as well, for the first time: what it works with is to be given threads.
    pub(super) fn begins(&mut self) -> bool {
        let begins = self.trials == TRIALS && self.shortest > SHORT;
        self.trials += usize::from(begins);
        begins
    }

    /// Does the work without the interpreter lock.
    pub(super) fn run<R: Send>(
        &mut self,
        py: Python<'_>,
        work: impl FnOnce() -> R + Send,
    ) -> PyResult<R> {
        if self.trials > TRIALS {
            return beside_pool(py, work);
        }
        let begin = Instant::now();
        let out = py.detach(|| guarded(work))?;
        if self.trials < TRIALS {
            self.trials += 1;
            self.shortest = self.shortest.min(begin.elapsed());
        }
        Ok(out)
    }
}
