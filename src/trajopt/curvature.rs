//! Second derivatives that a solver takes into account.

/// Second derivatives that a solver takes into account.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Curvature {
    /// Second derivatives of the costs as Gauss and Newton have them; none of the dynamics (iLQR).
    #[default]
    GaussNewton,
    /// The exact Hessian of the costs and the second-order terms of the dynamics (DDP), by hyper-dual numbers: many
    /// evaluations, which allocate. Constraints keep the Hessian of Gauss and Newton; so does all else in an iteration
    /// where the exact one is not convex. Fewer iterations near an optimum, each many times as long: for an arm of
    /// seven joints some thirty times.
    Exact,
}
