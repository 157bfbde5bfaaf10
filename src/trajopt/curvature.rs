//! Second derivatives that a solver takes into account.

use super::system::AnySystem;

/// Second derivatives that a solver takes into account.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Curvature {
    /// Second derivatives of the costs as Gauss and Newton have them; none of the dynamics (iLQR).
    #[default]
    GaussNewton,
    /// The exact Hessian of the costs and the second-order terms of the dynamics (DDP), by hyper-dual numbers: many
    /// evaluations, which allocate. Constraints keep the Hessian of Gauss and Newton; so does all else in an iteration
    /// where the exact one is not convex. Fewer iterations near an optimum, each many times as long: for an arm of
    /// seven joints some thirty times. Needs the feature `second-order`; without it solvers return
    /// [`Status::NoStepHessian`](super::Status::NoStepHessian).
    Exact,
}

impl Curvature {
    /// Whether a system has the second derivatives that are to be taken into account.
    pub(super) fn is_known_of(self, system: &dyn AnySystem) -> bool {
        match self {
            Self::GaussNewton => true,
            Self::Exact => system.has_step_hessian(),
        }
    }
}
