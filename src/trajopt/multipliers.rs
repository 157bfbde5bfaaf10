//! The augmented Lagrangian for a solver without constraints: a sequence of problems with multipliers that converge to the forces of the constraints,
//! and a penalty that is raised if violations do not decrease.
//!
//! [Howell, Jackson, Manchester 2019, ALTRO; Nocedal, Wright 2006, section 17.4].

use crate::minimize::Status;
use crate::numbers::Domain;

/// Options of the penalty of constraints: of an augmented Lagrangian, or of the exact penalty of `Transcription`, which has its own defaults.
#[derive(Clone, Debug, PartialEq)]
pub struct ConstraintOptions {
    /// Largest violation of a constraint, in its own unit; 1e-6 by default.
    pub tolerance: f64,
    /// Initial penalty μ, 10 by default; a larger value satisfies constraints sooner, and makes the first problem stiffer.
    pub penalty: f64,
    /// Factor by which the penalty increases, 10 by default.
    pub penalty_increase: f64,
    /// Maximum penalty, 1e8 by default.
    pub max_penalty: f64,
    /// The penalty increases if a violation does not decrease by this factor, 0.25 by default.
    pub violation_decrease: f64,
}

impl Default for ConstraintOptions {
    fn default() -> Self {
        Self {
            tolerance: 1e-6,
            penalty: 10.0,
            penalty_increase: 10.0,
            max_penalty: 1e8,
            violation_decrease: 0.25,
        }
    }
}

impl ConstraintOptions {
    pub(super) fn check(&self) {
        Domain::NotNegativeOrInfinite.check("tolerance of the constraints", self.tolerance);
        let (penalty, increase) = (self.penalty, self.penalty_increase);
        assert!(
            penalty > 0.0,
            "the penalty is {penalty}, expected a positive number"
        );
        assert!(
            increase > 1.0,
            "penalty_increase is {increase}, expected a factor above 1"
        );
    }

    fn raised(&self, penalty: f64) -> f64 {
        (penalty * self.penalty_increase).min(self.max_penalty)
    }
}

/// Factor by which the tolerance falls from one problem to the next.
const TOLERANCE_DECREASE: f64 = 0.1;

/// A solver at fixed multipliers.
pub(super) trait AtMultipliers {
    /// Goes on from where it is, to a tolerance of its own kind.
    fn descend(&mut self, tolerance: f64) -> Status;

    /// The largest violation of a constraint where it is.
    fn violation(&self) -> f64;

    /// λ from the violations where it is, then this penalty.
    fn update(&mut self, penalty: f64);
}

/// Tolerances of the problems at fixed multipliers, in sequence.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tolerances {
    /// Tolerance while the multipliers are not yet right.
    pub(super) first: f64,
    /// Tolerance at the end.
    pub(super) last: f64,
}

/// Descends, to tolerances from the first to the last, until the constraints hold; multipliers start at zero, the
/// penalty as the options say.
pub(super) fn meet_constraints(
    solver: &mut impl AtMultipliers,
    options: &ConstraintOptions,
    Tolerances { first, last }: Tolerances,
) -> Status {
    let (mut tolerance, mut penalty) = (first.max(last), options.penalty);
    let mut before = f64::INFINITY;
    loop {
        let status = solver.descend(tolerance);
        let violation = solver.violation();
        let holds = violation <= options.tolerance;
        match status {
            Status::Converged | Status::LineSearchStalled | Status::NotConvex
                if !holds || tolerance > last => {}
            _ => return status,
        }
        if !violation.is_finite() {
            return Status::Diverged;
        }
        let shrinks = violation < options.violation_decrease * before;
        if !holds && !shrinks {
            if penalty >= options.max_penalty {
                return Status::Infeasible;
            }
            penalty = options.raised(penalty);
        }
        before = violation;
        tolerance = (tolerance * TOLERANCE_DECREASE).max(last);
        solver.update(penalty);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TOLERANCES: Tolerances = Tolerances {
        first: 1e-3,
        last: 1e-5,
    };

    /// A solver whose violation shrinks by a factor at each update, and that keeps the penalties it was given.
    struct Shrinking {
        violation: f64,
        factor: f64,
        penalties: Vec<f64>,
        tolerances: Vec<f64>,
    }

    impl Shrinking {
        fn by(factor: f64) -> Self {
            Self {
                violation: 1.0,
                factor,
                penalties: Vec::new(),
                tolerances: Vec::new(),
            }
        }
    }

    impl AtMultipliers for Shrinking {
        fn descend(&mut self, tolerance: f64) -> Status {
            self.tolerances.push(tolerance);
            Status::Converged
        }
        fn violation(&self) -> f64 {
            self.violation
        }
        fn update(&mut self, penalty: f64) {
            self.violation *= self.factor;
            self.penalties.push(penalty);
        }
    }

    #[test]
    fn penalty_stays_while_violations_shrink_and_tolerances_fall_to_the_last() {
        let mut solver = Shrinking::by(0.1);
        let options = ConstraintOptions {
            tolerance: 2e-6,
            ..ConstraintOptions::default()
        };
        let status = meet_constraints(&mut solver, &options, TOLERANCES);
        assert_eq!(status, Status::Converged);
        // From 1 to 10⁻⁶.
        assert_eq!(solver.penalties, [options.penalty; 6]);
        assert!((solver.tolerances[1] - 1e-4).abs() < 1e-18);
        assert_eq!(solver.tolerances[2..], [1e-5; 5]);
    }

    #[test]
    fn violation_that_stays_raises_the_penalty_to_its_limit_and_is_infeasible() {
        let mut solver = Shrinking::by(1.0);
        let options = ConstraintOptions {
            max_penalty: 1e3,
            ..ConstraintOptions::default()
        };
        let status = meet_constraints(&mut solver, &options, TOLERANCES);
        assert_eq!(status, Status::Infeasible);
        assert_eq!(solver.penalties, [10.0, 100.0, 1000.0]);
    }

    #[test]
    fn violation_that_is_not_finite_is_divergence() {
        let mut solver = Shrinking::by(f64::INFINITY);
        let status = meet_constraints(&mut solver, &ConstraintOptions::default(), TOLERANCES);
        assert_eq!(status, Status::Diverged);
    }
}
