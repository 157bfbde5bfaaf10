//! Second derivatives that a solver takes into account.

use super::system::AnySystem;

/// Second derivatives that a solver takes into account.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Curvature {
    /// Gauss–Newton Hessians of the costs, without second derivatives of the dynamics (iLQR).
    #[default]
    GaussNewton,
    /// The exact Hessian of the costs and the second-order terms of the dynamics (DDP), by hyper-dual numbers: many evaluations, which allocate.
    /// Constraints keep the Gauss–Newton Hessian; so do the costs and dynamics in an iteration with a nonconvex exact Hessian. It needs fewer
    /// iterations near an optimum, but each takes much longer: about thirty times for an arm of seven joints. Without the feature `second-order`
    /// solvers return [`Status::NoStepHessian`](super::Status::NoStepHessian).
    Exact,
}

impl Curvature {
    /// Whether a system has the second derivatives that are to be taken into account.
    pub(super) fn is_known_of(self, system: &dyn AnySystem) -> bool {
        match self {
            Self::GaussNewton => true,
            Self::Exact => cfg!(feature = "second-order") && system.has_step_hessian(),
        }
    }
}
