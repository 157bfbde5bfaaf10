//! The limit of memory of results whose size a caller chooses: steps of a rollout, states of a batch, stages of a problem, points of contact, nodes of
//! a grid.
//!
//! An operating system promises more memory than there is, and ends a program that uses it. So what would need more than a limit is refused
//! before any work:
//!
//! | what | how it is refused |
//! |---|---|
//! | a rollout | ends before the step whose state would be too much, with [`RolloutStatus::OutOfMemory`](crate::sim::RolloutStatus::OutOfMemory) |
//! | a batch of rollouts | ends before the first step, with the same status of each |
//! | a gradient of a rollout | ends before the first step, with the same status; fewer [checkpoints](crate::linearize::Checkpoints) need less |
//! | a problem of `trajopt` | `Problem::check_memory` is an error; solvers of it panic with its message |
//! | contact points | [`Contacts::with_meshes`](crate::contact::Contacts::with_meshes) and `with_options` are errors; constructors without `try` panic with their message |
//! | forces of contact points in a step | [`Contacts::check_memory`](crate::contact::Contacts::check_memory) is an error; a simulator of them panics with its message |
//! | a grid of heights, Jacobians of a step, a random tree, a plot, gradients that L-BFGS remembers | a panic with the message, before any work |
//! | samples of a filter, harmonics of a motion for identification | an `IdentifyError` |
//!
//! The limit is of the whole program: that of [`set_limit`], or else the memory of the machine or of the program's control group. It holds for
//! each result by itself, and does not count what there already is.
//!
//! # Examples
//! ```standalone_crate
//! use dualbody::{Simulator, State, memory, model::samples, sim::RolloutStatus};
//!
//! memory::set_limit(Some(100_000));
//! let pendulum = Simulator::new(samples::pendulum());
//! let swing = pendulum.rollout(&State::new(&[0.1], &[0.0]), usize::MAX, |_, _, _| {});
//! assert!(matches!(swing.status, RolloutStatus::OutOfMemory { step } if step > 100));
//! memory::set_limit(None);
//! assert!(memory::limit() > 100_000);
//! ```

use std::fmt::Display;
use std::fs::read_to_string;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

pub use crate::error::OutOfMemory;

/// The limit that was set, bytes; `usize::MAX` for what the machine has.
static LIMIT: AtomicUsize = AtomicUsize::new(usize::MAX);

/// Bytes above which a result is refused.
pub fn limit() -> usize {
    match LIMIT.load(Ordering::Relaxed) {
        usize::MAX => machine(),
        limit => limit,
    }
}

/// Sets the bytes above which a result is refused; `None` for what the machine has, as at the start of the program.
pub fn set_limit(bytes: Option<usize>) {
    LIMIT.store(bytes.unwrap_or(usize::MAX), Ordering::Relaxed);
}

/// Checks that a result may be as large as this.
///
/// * `what` – the result, a plural, for the message
/// * `bytes` – saturating, where a product overflows
///
/// # Errors
/// If that is more than the [`limit`].
pub fn check(what: impl Display, bytes: usize) -> Result<(), OutOfMemory> {
    let limit = limit();
    if bytes <= limit {
        return Ok(());
    }
    let what = what.to_string();
    Err(OutOfMemory { what, bytes, limit })
}

/// Returns a checked value; panics with the message of the error, for functions without an error.
#[track_caller]
pub(crate) fn granted<T>(checked: Result<T, OutOfMemory>) -> T {
    checked.unwrap_or_else(|error| panic!("{error}"))
}

/// Memory of the machine, or what its control group may use of it, bytes; as much as can be addressed where that is not known.
fn machine() -> usize {
    static FOUND: OnceLock<usize> = OnceLock::new();
    *FOUND.get_or_init(|| {
        let total = read_to_string("/proc/meminfo").ok();
        let total = total.and_then(|text| total_of(&text));
        let group = read_to_string("/sys/fs/cgroup/memory.max");
        let group = group.ok().and_then(|text| text.trim().parse().ok());
        let known = [total, group].into_iter().flatten().min();
        known.unwrap_or(isize::MAX as usize)
    })
}

/// Bytes of the line `MemTotal: … kB`.
fn total_of(text: &str) -> Option<usize> {
    let mut lines = text.lines();
    let line = lines.find_map(|line| line.strip_prefix("MemTotal:"))?;
    let kilobytes: usize = line.trim().trim_end_matches("kB").trim().parse().ok()?;
    kilobytes.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn total_memory_is_read_in_bytes() {
        let text = "MemFree: 12 kB\nMemTotal:       2048 kB\n";
        assert_eq!(total_of(text), Some(2 << 20));
        assert_eq!(total_of("MemFree: 12 kB"), None);
        assert_eq!(total_of("MemTotal: 99999999999999999999 kB"), None);
    }

    #[test]
    fn what_is_too_large_is_refused_by_name() {
        let error = check("7 trajectories", usize::MAX).unwrap_err();
        let text = error.to_string();
        assert!(
            text.starts_with("7 trajectories need 1.8e19 bytes"),
            "{text}"
        );
        assert!(check("nothing", 0).is_ok());
    }
}
