//! Cancellation of long calls.

use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

thread_local! {
    /// The signals of all active calls of [`StopSignal::watch`] on this thread.
    static WATCHED: RefCell<Vec<StopSignal>> = const { RefCell::new(Vec::new()) };
}

/// A signal that ends long calls within [`watch`](Self::watch): solvers of [`trajopt`](crate::trajopt), [`minimize`](crate::minimize),
/// [`least_squares`](crate::least_squares), and identification. They return the best result so far, with a status that reports the stop.
///
/// Copies share the signal. Set it from another thread, or from a function that the solver calls, for example its report. Solvers check it between
/// steps of a rollout, evaluations and iterations: they stop within a fraction of a second, except for very large problems. C compilers of
/// `dualbody-native` stop likewise.
///
/// # Examples
/// ```
/// use dualbody::{StopSignal, least_squares::{ByDuals, Options, Status, solve_with}};
/// # use dualbody::{Scalar, autodiff::VectorFunction};
/// # struct Valley;
/// # impl VectorFunction for Valley {
/// #     fn n_outputs(&self) -> usize { 2 }
/// #     fn eval<T: Scalar>(&self, x: &[T], r: &mut [T]) {
/// #         r[0] = (x[1] - x[0] * x[0]) * 10.0;
/// #         r[1] = -x[0] + 1.0;
/// #     }
/// # }
///
/// let signal = StopSignal::new();
/// let found = signal.watch(|| {
///     let mut report = |at: &dualbody::least_squares::Iteration| {
///         if at.iteration == 2 {
///             signal.stop();
///         }
///     };
///     solve_with(&mut ByDuals::new(Valley), &[-1.2, 1.0], &Options::default(), &mut report)
/// });
/// assert_eq!((found.status, found.iterations), (Status::Stopped, 2));
/// ```
#[derive(Clone, Debug, Default)]
pub struct StopSignal(Arc<AtomicBool>);

impl StopSignal {
    /// Makes a signal that is not set.
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets the signal permanently.
    pub fn stop(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether it is set.
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Runs work that ends early once the signal is set, on this thread and its worker threads.
    pub fn watch<R>(&self, work: impl FnOnce() -> R) -> R {
        let mut signals = Self::watched();
        signals.push(self.clone());
        watching(&signals, work)
    }

    /// The signals of all active [`watch`](Self::watch) calls of this thread, for long work of other crates: end it once one of them is set.
    ///
    /// # Examples
    /// ```
    /// use dualbody::StopSignal;
    ///
    /// let signal = StopSignal::new();
    /// signal.stop();
    /// assert!(signal.watch(|| StopSignal::watched()[0].is_set()));
    /// assert!(StopSignal::watched().is_empty());
    /// ```
    pub fn watched() -> Vec<Self> {
        WATCHED.with_borrow(Clone::clone)
    }
}

/// Runs work that looks at these signals, and at no others.
pub(crate) fn watching<R>(signals: &[StopSignal], work: impl FnOnce() -> R) -> R {
    /// Puts the signals of before back, after a panic too.
    struct Restored(Vec<StopSignal>);
    impl Drop for Restored {
        fn drop(&mut self) {
            WATCHED.set(std::mem::take(&mut self.0));
        }
    }
    let _restored = Restored(WATCHED.replace(signals.to_vec()));
    work()
}

/// Whether the work is to end.
pub(crate) fn is_stopped() -> bool {
    WATCHED.with_borrow(|signals| signals.iter().any(StopSignal::is_set))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signals_count_within_their_watch_on_all_threads_and_after_panics_not() {
        let (outer, inner) = (StopSignal::new(), StopSignal::new());
        outer.watch(|| {
            inner.watch(|| {
                assert!(!is_stopped());
                outer.stop();
                assert!(is_stopped());
            });
            let (mut workers, mut items) = ([(); 2], [false; 8]);
            crate::parallel::for_each_part(&mut workers, &mut items, |(), _, item| {
                *item = is_stopped();
            });
            assert_eq!(items, [true; 8]);
        });
        assert!(!is_stopped());
        let panicked = std::panic::catch_unwind(|| outer.watch(|| panic!("on purpose")));
        assert!(panicked.is_err() && !is_stopped());
    }
}
