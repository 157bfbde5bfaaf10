//! Work on many independent items, on one or several cores.

#[cfg(feature = "parallel")]
use crate::stop::{watched, watching};

/// The cores that there are to use: one without the feature `parallel`.
pub(crate) fn available_threads() -> usize {
    #[cfg(feature = "parallel")]
    return rayon::current_num_threads();
    #[cfg(not(feature = "parallel"))]
    return 1;
}

/// Cuts the items into one contiguous part for each worker, and hands every item with its index to `work`, part by part at
/// once, within a part one after the other. Without the feature `parallel` the parts come one after the other, too.
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
        let parts = workers.par_iter_mut().zip(items.par_chunks_mut(length));
        let signals = watched();
        return parts.enumerate().for_each(|(part, (worker, items))| {
            watching(&signals, || serve(part, worker, items));
        });
    }
    let parts = workers.iter_mut().zip(items.chunks_mut(length));
    parts
        .enumerate()
        .for_each(|(part, (worker, items))| serve(part, worker, items));
}
