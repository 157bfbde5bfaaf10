//! The solution of single shooting: a trajectory with its variables.

use crate::trajopt::solution::Solution;

/// A trajectory with its variables. It satisfies the dynamics.
pub type ShootingSolution = Solution<Variables>;

/// Results of single shooting only: the variables of the trajectory, see
/// [`SingleShooting`](super::SingleShooting).
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Variables {
    /// The variables; a start for further runs.
    pub variables: Vec<f64>,
}
