//! Memory limit of results whose size a caller chooses: steps of a rollout, states of a batch, stages of a problem, contact points, nodes of a grid.
//!
//! An operating system grants more memory than it has, and kills a program that uses it. So a result that would need more than a limit is refused
//! before any work:
//!
//! | result | refusal |
//! |---|---|
//! | a rollout | ends before the step that would exceed the limit, with [`RolloutStatus::OutOfMemory`](crate::sim::RolloutStatus::OutOfMemory) |
//! | a batch of rollouts | ends before the first step, with the same status for all |
//! | a gradient of a rollout | ends before the first step, with the same status; fewer [checkpoints](crate::linearize::Checkpoints) need less |
//! | a problem of `trajopt` | `Problem::check_memory` returns an error; solvers panic with its message |
//! | contact points | [`Contacts::with_meshes`](crate::contact::Contacts::with_meshes) and `with_options` return errors; other constructors panic with their message |
//! | forces of contact points in a step | [`Contacts::check_memory`](crate::contact::Contacts::check_memory) returns an error; a simulator panics with its message |
//! | a grid of heights, Jacobians of a step, a random tree, a plot, stored gradients of L-BFGS | a panic with the message |
//! | samples of a filter, harmonics of a motion for identification | an `IdentifyError` |
//!
//! The limit is global: the value of [`set_limit`], by default the memory of the machine or of the control group of the program. It applies to each
//! result separately, and does not include existing data.
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

/// Sets the bytes above which a result is refused; `None` for the default, the memory of the machine.
pub fn set_limit(bytes: Option<usize>) {
    LIMIT.store(bytes.unwrap_or(usize::MAX), Ordering::Relaxed);
}

/// Checks the size of a result against the limit.
///
/// * `what` – the result, as a plural noun for the message
/// * `bytes` – its size, saturated on overflow
///
/// # Errors
/// If the size exceeds the [`limit`].
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
