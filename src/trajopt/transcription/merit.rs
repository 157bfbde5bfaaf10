//! Merit of a trajectory, and its predicted reduction in a step: the exact penalty function  costs + Σ ν |defect| + ρ Σ
//! violation.
//!
//! [Powell 1978; Nocedal, Wright 2006, section 18.3].

/// Share of the predicted reduction that a step has to keep.
const ACCEPTED_SHARE: f64 = 1e-4;
/// Changes of the merit up to this share of it are rounding.
const ROUNDING: f64 = 1e-13;

/// Terms of the merit of a trajectory: its cost, and its distance from obeying the dynamics and the constraints.
#[derive(Clone, Copy, Debug)]
pub(super) struct Merit {
    /// The costs of the problem.
    pub(super) cost: f64,
    /// Σ ν |defect|.
    pub(super) weighed_defects: f64,
    /// Sum of all violations of constraints.
    pub(super) violations: f64,
    /// Largest defect.
    pub(super) gap: f64,
    /// Largest violation of a constraint.
    pub(super) violation: f64,
}

impl Merit {
    /// The exact penalty function, with the weight of the constraints.
    pub(super) fn total(&self, penalty: f64) -> f64 {
        self.cost + self.weighed_defects + penalty * self.violations
    }
}

/// The merit along a step, to first order.
#[derive(Clone, Copy, Debug)]
pub(super) struct PredictedReduction {
    pub(super) merit: f64,
    /// Derivative of the merit along the step, below zero.
    pub(super) slope: f64,
}

impl PredictedReduction {
    /// Whether the merit, this far along the step, has fallen as it should.
    pub(super) fn is_sufficient(&self, merit: f64, alpha: f64) -> bool {
        let allowed = ROUNDING * (1.0 + self.merit.abs());
        merit - self.merit <= ACCEPTED_SHARE * alpha * self.slope + allowed
    }

    /// The fall of the merit as a share of that of a parabola whose lowest point is one step away; one where both are
    /// rounding.
    pub(super) fn achieved_share(&self, merit: f64) -> f64 {
        let rounding = ROUNDING * (1.0 + self.merit.abs());
        (self.merit - merit + rounding) / (-0.5 * self.slope + rounding)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::OTHER_ALGORITHM;

    // m(α) = 7 − 2 α + α²: slope −2, lowest one step away, 6.
    const PREDICTED: PredictedReduction = PredictedReduction {
        merit: 7.0,
        slope: -2.0,
    };

    #[test]
    fn parabola_achieves_its_whole_reduction_at_its_lowest_point() {
        assert!((PREDICTED.achieved_share(6.0) - 1.0).abs() < OTHER_ALGORITHM);
        assert!((PREDICTED.achieved_share(6.5) - 0.5).abs() < OTHER_ALGORITHM);
        assert!((PREDICTED.achieved_share(8.0) + 1.0).abs() < OTHER_ALGORITHM);
    }

    #[test]
    fn reduction_is_sufficient_from_a_share_of_the_slope_on() {
        for alpha in [1.0, 0.25] {
            let least = ACCEPTED_SHARE * alpha * 2.0;
            assert!(PREDICTED.is_sufficient(7.0 - 1.01 * least, alpha));
            assert!(!PREDICTED.is_sufficient(7.0 - 0.99 * least, alpha));
        }
    }

    #[test]
    fn total_adds_costs_defects_and_weighed_violations() {
        let merit = Merit {
            cost: 1.0,
            weighed_defects: 2.0,
            violations: 0.5,
            gap: 0.1,
            violation: 0.2,
        };
        assert_eq!(merit.total(10.0), 8.0);
    }
}
