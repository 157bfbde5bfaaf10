//! Threads of rayon, and the one that asks for their work.

use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::{Scope, ThreadPool};

use crate::stop::{StopSignal, watching};

thread_local! {
    /// The pool of [`beside_pool`].
    static POOL: RefCell<Option<Arc<ThreadPool>>> = const { RefCell::new(None) };
}

/// How often this thread looks whether the others are done before it sleeps, which is some 0.1 ms: to be woken takes a good part of that.
const LOOKS: usize = 5000;

/// Starts rayon's own threads with stacks as large as those of first threads of programs, unless the program has started them, or this is a thread of another
/// pool. Without optimisation steps of batches may need more than the 2 MiB that threads have else. The stacks are addresses; memory is what is used of them.
pub(super) fn start() {
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

/// Runs work on this thread, of which batches and other loops go to threads of a pool as well. Within [`ThreadPool::install`] this thread would wait, and
/// short work would begin a wake-up later.
pub fn beside_pool<R>(pool: &Arc<ThreadPool>, work: impl FnOnce() -> R) -> R {
    /// Puts the pool of before back, after a panic too.
    struct Restored(Option<Arc<ThreadPool>>);
    impl Drop for Restored {
        fn drop(&mut self) {
            POOL.set(self.0.take());
        }
    }
    let _restored = Restored(POOL.replace(Some(pool.clone())));
    work()
}

/// Serves the parts at once, the first one on this thread: only the others begin a wake-up later.
pub(super) fn at_once<P: Send>(
    mut parts: impl ExactSizeIterator<Item = P> + Send,
    serve: impl Fn(P) + Sync,
) {
    let (signals, waiting) = (StopSignal::watched(), AtomicUsize::new(parts.len() - 1));
    let serve = |part| watching(&signals, || serve(part));
    let (serve, waiting) = (&serve, &waiting);
    let first = parts.next();
    in_place(|scope| {
        for part in parts {
            scope.spawn(move |_| {
                serve(part);
                waiting.fetch_sub(1, Ordering::Release);
            });
        }
        first.into_iter().for_each(serve);
        // A thread of the pool does what is left of the work itself.
        let looks = rayon::current_thread_index().map_or(LOOKS, |_| 0);
        let is_open = |_: &usize| waiting.load(Ordering::Acquire) > 0;
        (0..looks)
            .take_while(is_open)
            .for_each(|_| std::hint::spin_loop());
    });
}

/// Runs the work of a scope, on this thread if it is sure of its stack.
fn in_place<'scope>(work: impl FnOnce(&Scope<'scope>) + Send) {
    let is_small = cfg!(debug_assertions);
    match POOL.with_borrow(Clone::clone) {
        Some(pool) if is_small => pool.scope(work),
        Some(pool) => pool.in_place_scope(work),
        None => {
            start();
            match is_small {
                true => rayon::scope(work),
                false => rayon::in_place_scope(work),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parallel::for_each_part;

    fn indices(workers: usize, items: usize) -> Vec<usize> {
        let (mut workers, mut out) = (vec![(); workers], vec![0; items]);
        for_each_part(&mut workers, &mut out, |(), k, out| *out += k + 1);
        out
    }

    #[test]
    fn each_item_is_served_once_wherever_the_work_is_asked_for() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build();
        let pool = Arc::new(pool.expect("threads"));
        for (workers, items) in [(1, 5), (2, 1), (2, 7), (3, 7), (5, 3), (4, 0)] {
            let all: Vec<usize> = (1..=items).collect();
            let found = || indices(workers, items);
            // More parts than threads too: who waits for them serves them.
            let ways = [found(), pool.install(found), beside_pool(&pool, found)];
            assert_eq!(ways, [(); 3].map(|()| all.clone()), "{workers} workers");
        }
    }

    #[test]
    fn parts_beside_a_pool_run_on_its_threads_and_panics_come_back() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
        let pool = Arc::new(pool.expect("a thread"));
        let own = std::thread::current().id();
        let mut ids = vec![None; 2];
        let note =
            |(): &mut (), _: usize, id: &mut Option<_>| *id = Some(std::thread::current().id());
        beside_pool(&pool, || for_each_part(&mut [(); 2], &mut ids, note));
        let others = pool.broadcast(|_| std::thread::current().id());
        let is_known = |id: &Option<_>| *id == Some(own) || *id == Some(others[0]);
        assert!(ids.iter().all(is_known) && ids[1] == Some(others[0]));
        for bad in [0, 1] {
            let work = |(): &mut (), k: usize, _: &mut ()| assert_ne!(k, bad, "on purpose");
            let run = || beside_pool(&pool, || for_each_part(&mut [(); 2], &mut [(); 2], work));
            assert!(std::panic::catch_unwind(std::panic::AssertUnwindSafe(run)).is_err());
            assert!(POOL.with_borrow(Option::is_none));
        }
    }
}
