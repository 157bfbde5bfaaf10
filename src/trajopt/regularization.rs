//! Regularisation of a Hessian from one iteration to the next.

use crate::numbers::Domain;

/// Options of the Tikhonov regularisation on the diagonal of a Hessian, which shortens steps where the model is inaccurate. It increases after bad
/// steps and decreases after good ones.
#[derive(Clone, Debug, PartialEq)]
pub struct RegularizationOptions {
    /// Initial value, 1e-9 by default; a larger value shortens the first steps.
    pub start: f64,
    /// Minimum value, 1e-9 by default.
    pub min: f64,
    /// Value above which the solver gives up, 1e9 by default.
    pub max: f64,
    /// Factor by which it increases and decreases, 10 by default.
    pub factor: f64,
}

impl Default for RegularizationOptions {
    fn default() -> Self {
        Self {
            start: 1e-9,
            min: 1e-9,
            max: 1e9,
            factor: 10.0,
        }
    }
}

impl RegularizationOptions {
    /// Options without regularisation until a Hessian needs it: for convex problems.
    pub fn none() -> Self {
        Self {
            start: 0.0,
            min: 0.0,
            ..Self::default()
        }
    }

    pub(super) fn check(&self) {
        let Self {
            start,
            min,
            max,
            factor,
            ..
        } = *self;
        assert!(
            factor > 1.0,
            "the factor of the regularisation is {factor}, expected one above 1"
        );
        assert!(
            (0.0..=max).contains(&min),
            "the regularisation has min = {min} and max = {max}, expected 0 ≤ min ≤ max"
        );
        Domain::NotNegativeOrInfinite.check("regularisation at the start", start);
    }

    pub(super) fn raised(&self, regularization: f64) -> f64 {
        // From zero, a factor would lead nowhere.
        let from = regularization.max(f64::EPSILON);
        (from * self.factor).min(self.max)
    }

    pub(super) fn lowered(&self, regularization: f64) -> f64 {
        (regularization / self.factor).max(self.min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regularization_rises_and_falls_by_its_factor_within_its_limits() {
        let options = RegularizationOptions::default();
        assert_eq!((options.raised(1e-3), options.lowered(1e-3)), (1e-2, 1e-4));
        assert_eq!((options.raised(1e9), options.lowered(1e-9)), (1e9, 1e-9));
        let none = RegularizationOptions::none();
        assert_eq!((none.start, none.lowered(0.0)), (0.0, 0.0));
        assert!(
            none.raised(0.0) > 0.0,
            "from zero a factor would lead nowhere"
        );
    }
}
