//! Options of differential dynamic programming.

use crate::numbers::Domain;
use crate::trajopt::curvature::Curvature;
use crate::trajopt::multipliers::ConstraintOptions;
use crate::trajopt::regularization::RegularizationOptions;

/// Options of [`Ddp`](super::Ddp).
#[derive(Clone, Debug, PartialEq)]
pub struct DdpOptions {
    /// Maximum number of iterations, 100 by default.
    pub max_iterations: usize,
    /// The solver has converged when an iteration with the least regularisation is predicted to change the cost by less than this times (1 + |cost|).
    /// 1e-9 by default; a larger value stops earlier. For nonsmooth systems, with contact or dry friction, 1e-6 is already accurate.
    pub tolerance: f64,
    /// Second derivatives; Gauss–Newton by default.
    pub curvature: Curvature,
    /// Threads for costs and step Jacobians, one by default. The result is bit-identical for any number; more than one thread needs the feature `parallel`.
    pub threads: usize,
    /// Maximum number of line-search steps, each half as long as the previous one; 10 by default.
    pub line_search_steps: usize,
    /// Regularisation of the input Hessian.
    pub regularization: RegularizationOptions,
    /// Augmented Lagrangian of the constraints.
    pub constraints: ConstraintOptions,
}

impl Default for DdpOptions {
    fn default() -> Self {
        Self {
            max_iterations: 100,
            tolerance: 1e-9,
            curvature: Curvature::GaussNewton,
            threads: 1,
            line_search_steps: 10,
            regularization: RegularizationOptions::default(),
            constraints: ConstraintOptions::default(),
        }
    }
}

impl DdpOptions {
    pub(super) fn check(&self) {
        Domain::NotNegativeOrInfinite.check("tolerance", self.tolerance);
        self.regularization.check();
        self.constraints.check();
    }
}
