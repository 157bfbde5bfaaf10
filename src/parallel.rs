//! Work on many independent items, on one or several cores.

#[cfg(feature = "parallel")]
use crate::stop::{StopSignal, watching};

/// Starts rayon's own threads with stacks as large as those of first threads of programs, unless the program has started them, or this is a thread of another
/// pool. Without optimisation steps of batches may need more than the 2 MiB that threads have else. The stacks are addresses; memory is what is used of them.
#[cfg(feature = "parallel")]
fn start_threads() {
    const STACK: usize = 8 << 20;
    static STARTED: std::sync::Once = std::sync::Once::new();
    if rayon::current_thread_index().is_some() {
        return;
    }
    STARTED.call_once(|| {
        // Where there can be no threads, rayon does without them only if it is not asked. The variable holds for all threads of a program.
        let is_chosen = std::env::var_os("RUST_MIN_STACK").is_some();
        if !cfg!(target_family = "wasm") && !is_chosen {
            let threads = rayon::ThreadPoolBuilder::new().stack_size(STACK);
            // An error says that they are there.
            let _ = threads.build_global();
        }
    });
}

/// The cores that there are to use: one without the feature `parallel`.
pub(crate) fn available_threads() -> usize {
    #[cfg(feature = "parallel")]
    {
        start_threads();
        rayon::current_num_threads()
    }
    #[cfg(not(feature = "parallel"))]
    1
}

/// Cuts the items into one contiguous part for each worker, and hands every item with its index to `work`, part by part at
/// once, within a part in sequence. Without the feature `parallel` the parts come in sequence, too.
pub(crate) fn for_each_part<W: Send, I: Send>(
    workers: &mut [W],
    items: &mut [I],
    work: impl Fn(&mut W, usize, &mut I) + Sync,
) {
    let length = items.len().div_ceil(workers.len()).max(1);
    let serve = |part: usize, worker: &mut W, items: &mut [I]| {
        for (k, item) in items.iter_mut().enumerate() {
            work(worker, part * length + k, item);
        }
    };
    #[cfg(feature = "parallel")]
    if workers.len() > 1 && items.len() > 1 {
        use rayon::prelude::*;
        start_threads();
        let parts = workers.par_iter_mut().zip(items.par_chunks_mut(length));
        let signals = StopSignal::watched();
        return parts.enumerate().for_each(|(part, (worker, items))| {
            watching(&signals, || serve(part, worker, items));
        });
    }
    let parts = workers.iter_mut().zip(items.chunks_mut(length));
    parts
        .enumerate()
        .for_each(|(part, (worker, items))| serve(part, worker, items));
}
