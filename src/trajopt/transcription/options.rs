//! Options of direct transcription.

use crate::numbers::Domain;
use crate::trajopt::multipliers::ConstraintOptions;
use crate::trajopt::regularization::RegularizationOptions;

/// Options of [`Transcription`](super::Transcription).
#[derive(Clone, Debug, PartialEq)]
pub struct TranscriptionOptions {
    /// Maximum number of iterations, 200 by default.
    pub max_iterations: usize,
    /// The solver has converged when the Karush–Kuhn–Tucker conditions hold to this times (1 + the largest entry of the cost gradient); 1e-6 by
    /// default, a larger value stops earlier. Below 1e-9 the quadratic programs are not accurate enough.
    pub tolerance: f64,
    /// Largest defect, an error of the rate ẋ in its own unit; 1e-7 by default.
    pub gap_tolerance: f64,
    /// Threads for rates, costs and their derivatives, one by default. The result is bit-identical for any number; more than one thread needs the
    /// feature `parallel`.
    pub threads: usize,
    /// Maximum number of line-search steps, each half as long as the previous one; 12 by default.
    pub line_search_steps: usize,
    /// Regularisation of the Hessian.
    pub regularization: RegularizationOptions,
    /// Tolerance of the constraints, and their exact penalty: its weight per unit of violation, by default 10 initially and 1e6 at most. Constraints
    /// with larger multipliers count as infeasible. A raised penalty is kept if at most the share `violation_decrease`, 0.9 by default, of the
    /// violations remains.
    pub constraints: ConstraintOptions,
}

impl Default for TranscriptionOptions {
    fn default() -> Self {
        Self {
            max_iterations: 200,
            tolerance: 1e-6,
            gap_tolerance: 1e-7,
            threads: 1,
            line_search_steps: 12,
            regularization: RegularizationOptions::default(),
            constraints: ConstraintOptions {
                max_penalty: 1e6,
                violation_decrease: 0.9,
                ..ConstraintOptions::default()
            },
        }
    }
}

impl TranscriptionOptions {
    pub(super) fn check(&self) {
        Domain::NotNegativeOrInfinite.check("tolerance", self.tolerance);
        Domain::NotNegativeOrInfinite.check("gap_tolerance", self.gap_tolerance);
        self.regularization.check();
        self.constraints.check();
    }
}
