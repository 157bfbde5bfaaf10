//! The solution of direct transcription: a trajectory at the nodes and in continuous time.

use super::curve::Curve;
use crate::trajopt::solution::Solution;

/// A trajectory at the nodes (all states, all inputs except the last), and as a function of time. Its cost is
/// the integral of the costs by Simpson's rule, and the final cost.
pub type TranscriptionSolution = Solution<Continuous>;

/// Results of direct collocation only: the trajectory in continuous time.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Continuous {
    /// States and inputs at all times; a start for further runs.
    pub curve: Curve,
}
