//! Merit of a trajectory, and its predicted reduction in a step: the exact penalty function  costs + Σ ν |defect| + ρ Σ violation.
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

    /// The fall of the merit as a share of that of a parabola whose lowest point is one step away; one where both are rounding.
    pub(super) fn achieved_share(&self, merit: f64) -> f64 {
        let rounding = ROUNDING * (1.0 + self.merit.abs());
        (self.merit - merit + rounding) / (-0.5 * self.slope + rounding)
    }
}
