//! What can be chosen.

/// Which second derivatives count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Curvature {
    /// Those of the costs as Gauss and Newton have them; none of the dynamics (iLQR).
    #[default]
    GaussNewton,
    /// The exact Hessian of the costs and the second-order terms of the dynamics (DDP), by hyper-dual numbers: many evaluations, which
    /// allocate. Constraints keep the Hessian of Gauss and Newton; so does all else in an iteration where the exact one is not convex.
    /// Fewer iterations near an optimum, each many times as long: for an arm of seven joints some thirty times.
    Exact,
}

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
    /// Largest violation of a constraint, in its own unit; 1e-6 by default.
    pub constraint_tolerance: f64,
    /// Penalty of the augmented Lagrangian at the start, 10 by default; larger meets constraints sooner, and makes the first problem
    /// stiffer.
    pub penalty: f64,
    /// Factor by which it rises, 10 by default.
    pub penalty_increase: f64,
    /// Its limit, 1e8 by default.
    pub max_penalty: f64,
    /// The penalty rises where a violation does not shrink by this factor, 0.25 by default.
    pub violation_decrease: f64,
}

/// Tolerance of the first problem of an augmented Lagrangian, whose multipliers are not yet right.
const FIRST_TOLERANCE: f64 = 1e-4;
/// By how much it falls from one problem to the next.
const TOLERANCE_DECREASE: f64 = 0.1;

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
            constraint_tolerance: 1e-6,
            penalty: 10.0,
            penalty_increase: 10.0,
            max_penalty: 1e8,
            violation_decrease: 0.25,
        }
    }
}

impl DdpOptions {
    pub(super) fn check(&self) {
        assert!(self.tolerance >= 0.0, "a tolerance is not negative");
        assert!(self.regularization_factor > 1.0, "a factor above one");
        assert!(self.penalty > 0.0, "a penalty is positive");
        assert!(self.penalty_increase > 1.0, "a factor above one");
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

    pub(super) fn first_tolerance(&self) -> f64 {
        FIRST_TOLERANCE.max(self.tolerance)
    }

    pub(super) fn next_tolerance(&self, tolerance: f64) -> f64 {
        (tolerance * TOLERANCE_DECREASE).max(self.tolerance)
    }
}
