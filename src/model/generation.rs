//! Identity of the parameters of a model.

use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};

/// Differs between any two models, and between a model before and after a change of its bodies or armature; clones
/// share it. Working memory that holds what follows from these numbers is known by it.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) struct Generation(u64);

impl Generation {
    /// One that has never been.
    pub(crate) fn next() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Self(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}

/// Prints without the identity, so that equal robots print equally.
impl fmt::Debug for Generation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Generation")
    }
}
