//! Termination status of a solver.

use std::fmt;

/// A cost beyond this size has no limit: divergence.
pub(crate) const COST_LIMIT: f64 = 1e25;

/// Termination status of a solution, whatever the solver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Status {
    /// No improvement is expected any more, gaps are closed, constraints hold.
    Converged,
    /// All iterations were used; the trajectory is the best so far.
    IterationLimit,
    /// No step improves, however short and however much regularised.
    LineSearchStalled,
    /// No regularisation within its limit makes the quadratic model convex and solvable, so that there is no direction
    /// to search along.
    NotConvex,
    /// The guess leads to numbers that are not finite, or the cost falls without limit.
    Diverged,
    /// A [`StopSignal`](crate::StopSignal) was set; the trajectory is the best so far.
    Stopped,
    /// The constraints cannot be met near the trajectory: their violation stays at the largest penalty.
    Infeasible,
    /// [`Curvature::Exact`](crate::trajopt::Curvature::Exact) was asked for, and the [system](crate::trajopt::System::has_step_hessian) has no Hessians of its step: those of
    /// robots are compiled with the feature `second-order`. The trajectory is the guess.
    NoStepHessian,
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Converged => "converged",
            Self::IterationLimit => "all iterations used",
            Self::LineSearchStalled => "the line search found no step",
            Self::NotConvex => "the regularised model is not convex",
            Self::Diverged => "diverged",
            Self::Stopped => "stopped by a signal",
            Self::Infeasible => "the constraints cannot be met",
            Self::NoStepHessian => {
                "exact curvature needs second derivatives of steps: enable the feature `second-order` of dualbody"
            }
        })
    }
}
