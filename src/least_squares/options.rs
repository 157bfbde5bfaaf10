//! Options of the solver.

use super::Loss;

/// Options of [`solve`](super::solve).
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Largest number of iterations; 100 by default.
    pub max_iterations: usize,
    /// Cosine between the residuals and the columns of their Jacobian below which the solver has converged; 1e-10 by default. Dimensionless.
    pub gradient_tolerance: f64,
    /// Relative change of the cost, actual and predicted, below which the solver has converged; 1e-14 by default.
    pub cost_tolerance: f64,
    /// Size of a step relative to that of the variables, both in the scale of the residuals, below which the solver has converged; 1e-14 by default.
    /// For variables with fewer directions than coordinates (rotations), the size of each is 1.
    pub step_tolerance: f64,
    /// Relative offset below which the solver has converged; 0 by default. It is the root mean square of the reduction of the residuals by the next
    /// full step, per direction, relative to that of the remainder, per degree of freedom of the residuals: with 1e-3, measurement errors are a
    /// thousand times as large as the reduction. Use it if residuals are measurement errors [Bates, Watts 1981].
    pub offset_tolerance: f64,
    /// λ of the first step, relative to the squared columns of the Jacobian; 1e-3 by default. Use a smaller value for a good start.
    pub damping: f64,
    /// Loss function of the residuals; the square by default.
    pub loss: Loss,
    /// Lower bounds of the variables; empty (the default) for none, −∞ for a variable without a bound. If some variables have fewer directions than
    /// coordinates (rotations), bounds of the plain variables before the first of these.
    pub lower: Vec<f64>,
    /// Upper bounds of the variables; empty (the default) for none, ∞ for a variable without a bound. Same length rule as [`lower`](Self::lower).
    pub upper: Vec<f64>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            max_iterations: 100,
            gradient_tolerance: 1e-10,
            cost_tolerance: 1e-14,
            step_tolerance: 1e-14,
            offset_tolerance: 0.0,
            damping: 1e-3,
            loss: Loss::Square,
            lower: Vec::new(),
            upper: Vec::new(),
        }
    }
}

impl Options {
    /// Sets the bounds of the variables, ±∞ for none: one for each variable, or, if some variables are on a manifold, for the plain variables before these.
    #[must_use]
    pub fn with_bounds(mut self, lower: &[f64], upper: &[f64]) -> Self {
        self.lower = lower.to_vec();
        self.upper = upper.to_vec();
        self
    }

    pub(super) fn check(&self, variables: usize, directions: usize) {
        self.loss.check();
        assert!(
            self.damping > 0.0 && self.damping.is_finite(),
            "the damping {} of the first step is not positive",
            self.damping
        );
        for (name, bounds) in [("lower", &self.lower), ("upper", &self.upper)] {
            let fits = match directions == variables {
                true => bounds.is_empty() || bounds.len() == variables,
                false => bounds.len() < directions,
            };
            assert!(
                fits,
                "{} {name} bounds for {variables} variables with {directions} directions",
                bounds.len()
            );
        }
        let pairs = self.lower.iter().zip(&self.upper).enumerate();
        for (i, (lower, upper)) in pairs {
            assert!(
                lower <= upper,
                "the bounds {lower} and {upper} of variable {i} leave no value"
            );
        }
    }
}
