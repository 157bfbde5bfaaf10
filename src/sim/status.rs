//! Decides whether a trajectory continues after a step, for a rollout and for the lanes of a batch.

use std::ops::Range;

use super::state::State;
use crate::cone::Status;
use crate::scalar::Scalar;

/// Status of a rollout at its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum RolloutStatus {
    /// All steps were taken.
    Completed,
    /// The input of this step was not finite; the trajectory ends at the state before this step.
    NonFiniteInput {
        /// Index of the step, from 0.
        step: usize,
    },
    /// The state after this step was not finite, or exceeded the [divergence bound](super::Simulator::with_divergence_bound); the trajectory ends before it.
    Diverged {
        /// Index of the step, from 0.
        step: usize,
    },
    /// The state after this step, and in a batch the states of all trajectories, would need more memory than the [limit](crate::memory); the
    /// trajectory ends before it.
    OutOfMemory {
        /// Index of the step, from 0.
        step: usize,
    },
}

/// A step in which the solver of the forces of contact and constraints failed. The trajectory continues with the best forces found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct SolverFailure {
    /// Index of the step, from 0.
    pub step: usize,
    /// Status of the solver: worse than [`Acceptable`](Status::Acceptable).
    pub status: Status,
}

impl SolverFailure {
    /// Notes the failure of a step, if it is one, and the first.
    #[inline]
    pub(super) fn note(first: &mut Option<Self>, step: usize, status: Status) {
        if first.is_none() && status > Status::Acceptable {
            *first = Some(Self { step, status });
        }
    }
}

impl RolloutStatus {
    /// Status of a trajectory that ends before a step, by the input in these lanes; `None` if all continue.
    #[inline]
    pub(crate) fn before<T: Scalar>(step: usize, u: &[T], lanes: Range<usize>) -> Option<Self> {
        let zero = plus_zeros(T::zero(), u);
        (!are_all(lanes, |lane| zero.value(lane) == 0.0)).then_some(Self::NonFiniteInput { step })
    }

    /// Status of a trajectory that ends with a step, by the state after it in these lanes; `None` if all continue.
    ///
    /// * `bound` – [`Simulator::divergence_bound`](super::Simulator::divergence_bound)
    #[inline]
    pub(crate) fn after<T: Scalar>(
        step: usize,
        next: &State<T>,
        bound: f64,
        lanes: Range<usize>,
    ) -> Option<Self> {
        let parts = [&next.q, &next.v, &next.contact, &next.activation];
        let zero = (parts.into_iter()).fold(T::zero(), |sum, x| plus_zeros(sum, x.as_slice()));
        let speed = (next.v.iter()).fold(T::zero(), |speed, v| speed.max(v.abs()));
        let goes_on = |lane| (zero.value(lane) == 0.0) & (speed.value(lane) <= bound);
        (!are_all(lanes, goes_on)).then_some(Self::Diverged { step })
    }
}

/// Adds the product of each number with zero, which is zero only for finite numbers.
#[inline]
fn plus_zeros<T: Scalar>(sum: T, numbers: &[T]) -> T {
    numbers.iter().fold(sum, |sum, &x| sum + x * 0.0)
}

/// Whether all lanes are so, without a branch for each.
#[inline]
fn are_all(lanes: Range<usize>, are: impl Fn(usize) -> bool) -> bool {
    lanes.fold(true, |all, lane| all & are(lane))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Lanes;
    use nalgebra::DVector;

    #[test]
    fn each_lane_ends_by_its_own_numbers_and_all_of_them_by_any() {
        let one = |x: [f64; 4]| DVector::from_element(1, Lanes(x));
        let next = State {
            q: one([0.0, f64::NAN, 0.0, 0.0]),
            v: one([-5.0, 0.0, f64::NEG_INFINITY, 5.1]),
            contact: one([0.0; 4]),
            activation: one([0.0; 4]),
            sleep: one([0.0; 4]),
        };
        let after = |lanes| RolloutStatus::after(7, &next, 5.0, lanes).is_none();
        assert_eq!(
            [0, 1, 2, 3].map(|k| after(k..k + 1)),
            [true, false, false, false]
        );
        assert!(!after(0..4));
        let u = one([1e300, f64::INFINITY, 0.0, f64::NAN]);
        let before = |lanes| RolloutStatus::before(7, u.as_slice(), lanes).is_none();
        assert_eq!(
            [0, 1, 2, 3].map(|k| before(k..k + 1)),
            [true, false, true, false]
        );
        assert!(!before(0..4));
    }
}
