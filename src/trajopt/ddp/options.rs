//! Options of differential dynamic programming.

use crate::trajopt::curvature::Curvature;
use crate::trajopt::multipliers::ConstraintOptions;
use crate::trajopt::regularization::RegularizationOptions;

/// Options of [`Ddp`](super::Ddp).
#[derive(Clone, Debug, PartialEq)]
pub struct DdpOptions {
    /// Most iterations, 100 by default.
    pub max_iterations: usize,
    /// Converged when an iteration, with the least regularisation, is expected to change the cost by less than this
    /// times (1 + |cost|). 1e-9 by default; larger stops earlier. Where the system has kinks, as contact and dry
    /// friction have, 1e-6 is much already.
    pub tolerance: f64,
    /// Second derivatives; Gauss–Newton by default.
    pub curvature: Curvature,
    /// Threads for costs and step Jacobians, one by default. The result is the same, bit for bit, for any number; more
    /// than one need the feature `parallel`.
    pub threads: usize,
    /// Lengths that the line search tries, each half the one before; 10 by default.
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
        assert!(self.tolerance >= 0.0, "a tolerance is not negative");
        self.regularization.check();
        self.constraints.check();
    }
}
