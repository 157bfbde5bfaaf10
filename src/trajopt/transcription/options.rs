//! Options of direct transcription.

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
    pub defect_tolerance: f64,
    /// Largest violation of a constraint, in its own unit; 1e-6 by default.
    pub constraint_tolerance: f64,
    /// Threads for rates, costs and their derivatives, one by default. The result is the same, bit for bit, for any number; more than
    /// one need the feature `parallel`.
    pub threads: usize,
    /// Lengths that the line search tries, each half the one before; 12 by default.
    pub line_search_steps: usize,
    /// Regularisation of the Hessian.
    pub regularization: RegularizationOptions,
    /// Price of a violated constraint at the start, for each unit of violation; 10 by default. Larger meets constraints sooner.
    pub penalty: f64,
    /// Factor by which it rises where constraints stay violated, 10 by default.
    pub penalty_increase: f64,
    /// Its limit, 1e6 by default: constraints whose multipliers are larger count as impossible.
    pub max_penalty: f64,
}

impl Default for TranscriptionOptions {
    fn default() -> Self {
        Self {
            max_iterations: 200,
            tolerance: 1e-6,
            defect_tolerance: 1e-7,
            constraint_tolerance: 1e-6,
            threads: 1,
            line_search_steps: 12,
            regularization: RegularizationOptions::default(),
            penalty: 10.0,
            penalty_increase: 10.0,
            max_penalty: 1e6,
        }
    }
}

impl TranscriptionOptions {
    pub(super) fn check(&self) {
        let tolerances = [
            self.tolerance,
            self.defect_tolerance,
            self.constraint_tolerance,
        ];
        let in_range = tolerances.iter().all(|&tolerance| tolerance >= 0.0);
        assert!(in_range, "a tolerance is not negative");
        self.regularization.check();
        assert!(self.penalty > 0.0, "a penalty is positive");
        assert!(self.penalty_increase > 1.0, "a factor above one");
    }
}
