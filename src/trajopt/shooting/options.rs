//! Options of single shooting.

use crate::minimize;
use crate::minimize::Minimizer;
use crate::trajopt::curvature::Curvature;
use crate::trajopt::multipliers::ConstraintOptions;

/// Options of [`SingleShooting`](super::SingleShooting).
#[derive(Clone, Debug, PartialEq)]
pub struct ShootingOptions {
    /// Maximum number of iterations, 500 by default.
    pub max_iterations: usize,
    /// The method has converged when no entry of the gradient is larger than this times (1 + cost), or than this if the cost is negative. 1e-7 by
    /// default; a larger value stops earlier.
    pub tolerance: f64,
    /// Second derivatives in the Hessian; Gauss–Newton by default, which is never indefinite for convex costs.
    pub curvature: Curvature,
    /// The method for generic code over the trait [`Solver`](crate::trajopt::Solver); L-BFGS by default.
    pub minimizer: Minimizer,
    /// Number of gradients that L-BFGS stores, 10 by default, and at most the number of iterations; more gradients need fewer iterations and more memory.
    pub memory: usize,
    /// First radius of the trust region, in the units of the inputs; 100 by default.
    pub radius: f64,
    /// Augmented Lagrangian of the constraints.
    pub constraints: ConstraintOptions,
}

impl Default for ShootingOptions {
    fn default() -> Self {
        Self {
            max_iterations: 500,
            tolerance: 1e-7,
            curvature: Curvature::GaussNewton,
            minimizer: Minimizer::Lbfgs,
            memory: 10,
            radius: 100.0,
            constraints: ConstraintOptions::default(),
        }
    }
}

impl ShootingOptions {
    pub(super) fn check(&self) {
        minimize::check(self.tolerance, self.memory, self.radius);
        self.constraints.check();
    }
}
