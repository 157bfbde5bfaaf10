//! Work on many independent items, on one or several cores.

#[cfg(feature = "parallel")]
mod threads;

#[cfg(feature = "parallel")]
pub use threads::beside_pool;

/// The cores that there are to use: one without the feature `parallel`.
pub(crate) fn available_threads() -> usize {
    #[cfg(feature = "parallel")]
    {
        threads::start();
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
    let parts = workers.iter_mut().zip(items.chunks_mut(length)).enumerate();
    #[cfg(feature = "parallel")]
    if parts.len() > 1 {
        return threads::at_once(parts, |(part, (worker, items))| serve(part, worker, items));
    }
    parts.for_each(|(part, (worker, items))| serve(part, worker, items));
}
