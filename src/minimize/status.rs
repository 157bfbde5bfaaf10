//! Termination status of a solver.

use std::fmt;

/// A cost beyond this size has no limit: divergence.
pub(crate) const COST_LIMIT: f64 = 1e25;

/// Termination status of any solver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Status {
    /// No further improvement is expected, gaps are closed, constraints hold.
    Converged,
    /// All iterations were used; the trajectory is the best so far.
    IterationLimit,
    /// No step reduces the cost, at any length and regularisation.
    LineSearchStalled,
    /// No regularisation within its limit makes the quadratic model convex and solvable, so there is no search direction.
    NotConvex,
    /// The guess leads to values that are not finite, or the cost decreases without bound.
    Diverged,
    /// A [`StopSignal`](crate::StopSignal) was set; the trajectory is the best so far.
    Stopped,
    /// The constraints cannot be satisfied near the trajectory: violations remain at the largest penalty.
    Infeasible,
    /// [`Curvature::Exact`](crate::trajopt::Curvature::Exact) was requested, but the [system](crate::trajopt::System::has_step_hessian) has no
    /// Hessian of its step, which needs the feature `second-order`. The trajectory is the guess.
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
