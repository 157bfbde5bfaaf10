//! Options of the solver.

use super::Loss;

/// Options of [`solve`](super::solve).
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Largest number of iterations; 100 by default.
    pub max_iterations: usize,
    /// Cosine between the residuals and the columns of their Jacobian below which there is nothing to gain; 1e-10 by default. It has no unit.
    pub gradient_tolerance: f64,
    /// Change of the cost, found and predicted, beside the cost itself, below which it is at its least; 1e-14 by default.
    pub cost_tolerance: f64,
    /// Size of a step beside that of the variables, both in the scale of the residuals, below which it counts for nothing; 1e-14 by default. Where variables
    /// have fewer directions than numbers (rotations), each counts as 1.
    pub step_tolerance: f64,
    /// Relative offset below which an estimate counts as found; 0 by default. It is the root mean square of what the next full step would take off the residuals, for each
    /// direction, beside that of what would stay, for each residual to spare: with 1e-3, errors of measurement hide a thousand times as much. Of use where residuals are
    /// such errors [Bates, Watts 1981].
    pub offset_tolerance: f64,
    /// λ of the first step, beside the squared columns of the Jacobian; 1e-3 by default. Smaller where the start is good.
    pub damping: f64,
    /// Loss of each residual; the square by default.
    pub loss: Loss,
    /// Least values of the variables; empty by default, for none. −∞ for a variable without. Where variables have fewer directions than numbers (rotations),
    /// those of the plain numbers before the first of these.
    pub lower: Vec<f64>,
    /// Largest values of the variables; empty by default, for none. ∞ for a variable without. As many as [`lower`](Self::lower) may have.
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
    /// Sets the bounds of the variables, ±∞ for none: as many as there are, or those of the plain numbers at the front, where others are points of a curved space.
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
