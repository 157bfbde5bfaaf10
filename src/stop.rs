//! Early ends of long calls.

use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

thread_local! {
    /// The signals of all [`StopSignal::watch`] that this thread is in.
    static WATCHED: RefCell<Vec<StopSignal>> = const { RefCell::new(Vec::new()) };
}

/// A signal that ends what takes long: solvers of [`trajopt`](crate::trajopt), [`minimize`](crate::minimize), [`least_squares`](crate::least_squares),
/// and what identification runs of these, within [`watch`](Self::watch). They return the best that they have, with a status that says so.
///
/// Copies are the same signal. They may be set from another thread, or from a function that the work calls, its report say. Looked at
/// between steps of a rollout, evaluations and iterations: a fraction of a second for all but very large problems. C compilers of `dualbody-native` end
/// likewise.
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
    /// A signal that is not set.
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets the signal, for good.
    pub fn stop(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether it is set.
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Runs work that ends early once the signal is set, on this thread and on those that it spreads over.
    pub fn watch<R>(&self, work: impl FnOnce() -> R) -> R {
        let mut signals = Self::watched();
        signals.push(self.clone());
        watching(&signals, work)
    }

    /// The signals of all [`watch`](Self::watch) that this thread is in: for work of other crates that takes long. It ends once one of them is set.
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
