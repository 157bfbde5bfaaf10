//! What can be chosen.

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
    /// Regularisation of the Hessian at the start, 1e-9 by default; larger makes first steps shorter.
    pub regularization: f64,
    /// It never falls below this, 1e-9 by default.
    pub min_regularization: f64,
    /// Given up above this, 1e9 by default.
    pub max_regularization: f64,
    /// Factor by which it rises and falls, 10 by default.
    pub regularization_factor: f64,
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
            regularization: 1e-9,
            min_regularization: 1e-9,
            max_regularization: 1e9,
            regularization_factor: 10.0,
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
        assert!(self.regularization_factor > 1.0, "a factor above one");
        assert!(self.penalty > 0.0, "a penalty is positive");
        assert!(self.penalty_increase > 1.0, "a factor above one");
        assert!(
            (0.0..=self.max_regularization).contains(&self.min_regularization),
            "limits of the regularisation in their order"
        );
    }

    /// More regularisation, enough to be felt beside a Hessian of this size.
    pub(super) fn raised(&self, regularization: f64, hessian: f64) -> f64 {
        /// Share of the Hessian from which on a regularisation shortens steps.
        const FELT: f64 = 1e-6;
        let from = regularization.max(FELT * hessian).max(f64::EPSILON);
        (from * self.regularization_factor).min(self.max_regularization)
    }

    pub(super) fn lowered(&self, regularization: f64) -> f64 {
        (regularization / self.regularization_factor).max(self.min_regularization)
    }
}
