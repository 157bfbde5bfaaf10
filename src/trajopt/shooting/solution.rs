//! The solution of single shooting: a trajectory with the variables that give it.

use crate::trajopt::solution::Solution;

/// A trajectory with the variables that give it. It obeys the dynamics.
pub type ShootingSolution = Solution<Variables>;

/// Results that only single shooting gives: the variables of the trajectory, see
/// [`SingleShooting`](super::SingleShooting).
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Variables {
    /// The variables; a start for further runs.
    pub variables: Vec<f64>,
}
