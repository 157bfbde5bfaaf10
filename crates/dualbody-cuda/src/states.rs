//! States of a robot on a device, and how their motions end.

use dualbody::State;
use dualbody::sim::RolloutStatus;

use crate::error::CudaError;
use crate::numbers::{Numbers, Status};
use crate::real::Real;

/// Ending of the motion of a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// As in the library: completed, or stopped at an input or a state that is not finite or too fast.
    Rollout(RolloutStatus),
    /// A [condition](dualbody::scalar::Graph::conditions) of the graph is violated in step `step`.
    BrokenCondition {
        /// Index of the condition, from 0.
        condition: usize,
        /// Index of the step, from 0.
        step: usize,
    },
}

impl Ending {
    /// The ending of a status of a kernel after so many steps.
    pub(crate) fn new(status: i32, taken: u32) -> Self {
        let step = taken as usize;
        match usize::try_from(status) {
            Ok(0) => Self::Rollout(RolloutStatus::Completed),
            Ok(number) => Self::BrokenCondition {
                condition: number - 1,
                step,
            },
            Err(_) if status == NON_FINITE_INPUT => {
                Self::Rollout(RolloutStatus::NonFiniteInput { step })
            }
            Err(_) => Self::Rollout(RolloutStatus::Diverged { step }),
        }
    }
}

/// Status of kernels at an input that is not finite.
const NON_FINITE_INPUT: i32 = -2;

/// States of a batch that stay on the device from step to step.
#[derive(Debug)]
pub struct CudaStates<R = f64> {
    pub(crate) numbers: Numbers<R>,
    pub(crate) status: Status,
    /// A state with as many entries of each kind.
    pub(crate) like: State,
}

impl<R: Real> CudaStates<R> {
    /// Number of states.
    pub fn len(&self) -> usize {
        self.status.count()
    }

    /// `false`, as a batch has at least one state.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The entries of the states on the device: q, v, the contact state.
    pub fn numbers(&self) -> &Numbers<R> {
        &self.numbers
    }

    /// Copies all states from the device.
    ///
    /// # Errors
    /// If an earlier kernel, or the driver, has failed.
    pub fn to_vec(&self) -> Result<Vec<State>, CudaError> {
        let (all, rows) = (self.numbers.download_states()?, self.numbers.rows());
        let state = |row: &[R]| state(row, &self.like);
        Ok(all.chunks_exact(rows.max(1)).map(state).collect())
    }

    /// Steps that each state has taken.
    ///
    /// # Errors
    /// If an earlier kernel, or the driver, has failed.
    pub fn taken(&self) -> Result<Vec<u32>, CudaError> {
        self.status.taken()
    }

    /// Whether the motion of each state continues, or its ending.
    ///
    /// # Errors
    /// If an earlier kernel, or the driver, has failed.
    pub fn endings(&self) -> Result<Vec<Ending>, CudaError> {
        let (found, taken) = (self.status.found()?, self.status.taken()?);
        let both = found.into_iter().zip(taken);
        Ok(both
            .map(|(status, taken)| Ending::new(status, taken))
            .collect())
    }
}

/// The state of a row of numbers.
///
/// * `like` – a state with as many entries of each kind
pub(crate) fn state<R: Real>(row: &[R], like: &State) -> State {
    let mut out = like.clone();
    let numbers = out.numbers_mut().zip(row);
    numbers.for_each(|(out, x)| *out = x.to_f64());
    out
}

/// Numbers of one state after the other.
pub(crate) fn numbers<R: Real>(states: &[State]) -> Vec<R> {
    let all = states.iter().flat_map(State::numbers);
    all.map(|&x| R::from_f64(x)).collect()
}
