//! What can be chosen.

use crate::trajopt::curvature::Curvature;
use crate::trajopt::multipliers::ConstraintOptions;

/// Options of [`Ddp`](super::Ddp).
#[derive(Clone, Debug, PartialEq)]
pub struct DdpOptions {
    /// Most iterations, 100 by default.
    pub max_iterations: usize,
    /// Converged when an iteration is expected to change the cost by less than this times (1 + |cost|). 1e-9 by default; larger stops
    /// earlier.
    pub tolerance: f64,
    /// Second derivatives; Gauss–Newton by default.
    pub curvature: Curvature,
    /// Threads for costs and step Jacobians, one by default. The result is the same, bit for bit, for any number; more than one need
    /// the feature `parallel`.
    pub threads: usize,
    /// Lengths that the line search tries, each half the one before; 10 by default.
    pub line_search_steps: usize,
    /// Regularisation of the input Hessian at the start, 1e-9 by default; larger makes first steps shorter.
    pub regularization: f64,
    /// It never falls below this, 1e-9 by default.
    pub min_regularization: f64,
    /// Given up above this, 1e9 by default.
    pub max_regularization: f64,
    /// Factor by which it rises and falls, 10 by default.
    pub regularization_factor: f64,
    /// How constraints are met.
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
            regularization: 1e-9,
            min_regularization: 1e-9,
            max_regularization: 1e9,
            regularization_factor: 10.0,
            constraints: ConstraintOptions::default(),
        }
    }
}

impl DdpOptions {
    pub(super) fn check(&self) {
        assert!(self.tolerance >= 0.0, "a tolerance is not negative");
        assert!(self.regularization_factor > 1.0, "a factor above one");
        self.constraints.check();
        assert!(
            (0.0..=self.max_regularization).contains(&self.min_regularization),
            "limits of the regularisation in their order"
        );
    }

    pub(super) fn raised(&self, regularization: f64) -> f64 {
        // From zero, a factor would lead nowhere.
        let from = regularization.max(f64::EPSILON);
        (from * self.regularization_factor).min(self.max_regularization)
    }

    pub(super) fn lowered(&self, regularization: f64) -> f64 {
        (regularization / self.regularization_factor).max(self.min_regularization)
    }
}
