//! Options of direct transcription.

use crate::trajopt::multipliers::ConstraintOptions;
use crate::trajopt::regularization::RegularizationOptions;

/// Options of [`Transcription`](super::Transcription).
#[derive(Clone, Debug, PartialEq)]
pub struct TranscriptionOptions {
    /// Most iterations, 200 by default.
    pub max_iterations: usize,
    /// Converged when the conditions of Karush, Kuhn and Tucker hold to this times (1 + the largest entry of the gradient of the
    /// costs); 1e-6 by default, larger stops earlier. Below 1e-9 the quadratic programs are not exact enough.
    pub tolerance: f64,
    /// Largest defect, an error of the rate ẋ in its own unit; 1e-7 by default.
    pub gap_tolerance: f64,
    /// Threads for rates, costs and their derivatives, one by default. The result is the same, bit for bit, for any
    /// number; more than one need the feature `parallel`.
    pub threads: usize,
    /// Lengths that the line search tries, each half the one before; 12 by default.
    pub line_search_steps: usize,
    /// Regularisation of the Hessian.
    pub regularization: RegularizationOptions,
    /// Tolerance of the constraints, and their exact penalty: its weight for each unit of violation, 10 at the start,
    /// 1e6 at most by default. Constraints whose multipliers are larger count as impossible. A raised penalty is kept
    /// where it leaves at most `violation_decrease`, 0.9 by default, of the violations.
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
        let in_range = self.tolerance >= 0.0 && self.gap_tolerance >= 0.0;
        assert!(in_range, "a tolerance is not negative");
        self.regularization.check();
        self.constraints.check();
    }
}
