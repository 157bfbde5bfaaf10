//! Memory in which the kernels of a long function hand numbers to each other.

use std::num::NonZero;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use cudarc::driver::CudaSlice;

use crate::error::{CudaError, too_many};

/// Threads of a block. Kernels take up to 255 registers of the 65,536 of a multiprocessor, so that two blocks of 128 fit at least.
pub(crate) const THREADS: u32 = 128;

/// Default limit of a workspace, bytes.
const LIMIT: usize = 1 << 30;
/// Blocks that a multiprocessor takes at once, at least.
const BLOCKS: usize = 2;

/// The workspace of the stream of a device. Functions run in sequence there, so that all of them use the same memory, which stays for the next call.
#[derive(Debug)]
pub(crate) struct Workspace {
    memory: Mutex<Option<CudaSlice<u8>>>,
    limit: AtomicUsize,
}

impl Default for Workspace {
    fn default() -> Self {
        Self {
            memory: Mutex::new(None),
            limit: AtomicUsize::new(LIMIT),
        }
    }
}

/// The workspace while kernels are handed on: the memory, which is there, and the number of states that it has room for.
pub(crate) type Room<'a> = (MutexGuard<'a, Option<CudaSlice<u8>>>, usize);

impl Workspace {
    pub(crate) fn set_limit(&self, bytes: usize) {
        self.limit.store(bytes, Ordering::Relaxed);
    }

    /// Room for states that need so many bytes each: for all of them, or for as many as fit below the limit and keep the device busy.
    ///
    /// * `multiprocessors` – asks for the number of those of the device
    /// * `allocate` – makes memory of so many bytes
    pub(crate) fn room(
        &self,
        bytes: usize,
        count: usize,
        multiprocessors: impl FnOnce() -> Result<usize, CudaError>,
        allocate: impl FnOnce(usize) -> Result<CudaSlice<u8>, CudaError>,
    ) -> Result<Room<'_>, CudaError> {
        // A call that has failed leaves nothing that the next one reads.
        let mut memory = self.memory.lock().unwrap_or_else(PoisonError::into_inner);
        let (states, needed) = self.sizes(bytes, count, multiprocessors)?;
        if memory.as_ref().is_none_or(|own| own.len() < needed) {
            // The old memory is freed before the new allocation.
            *memory = None;
            *memory = Some(allocate(needed)?);
        }
        Ok((memory, states))
    }

    /// States of a piece of a batch, and the bytes that they need, at least one.
    fn sizes(
        &self,
        bytes: usize,
        count: usize,
        multiprocessors: impl FnOnce() -> Result<usize, CudaError>,
    ) -> Result<(usize, usize), CudaError> {
        let threads = THREADS as usize;
        let Some(block) = NonZero::new(bytes.saturating_mul(threads)) else {
            return Ok((count, 1));
        };
        // As many blocks as the device takes at once, some times over.
        let fewest = multiprocessors()?.max(1) * BLOCKS;
        let most = self.limit.load(Ordering::Relaxed) / block / fewest;
        let most = most.max(1).saturating_mul(fewest * threads);
        let states = most.min(count);
        let needed = states.div_ceil(threads).checked_mul(block.get());
        Ok((states, needed.ok_or_else(|| too_many("a workspace"))?))
    }
}
