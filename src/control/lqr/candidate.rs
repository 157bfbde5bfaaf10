//! Costs that may solve a Riccati equation, and the way to the one whose loop is stable.

use nalgebra::{Complex, DMatrix};

use super::LqrStatus;
use crate::control::doubling::Doubled;
use crate::control::riccati::Riccati;
use crate::control::{reachable_decomposition, stability};

/// Relative residual up to which P counts as a solution. It binds for systems within about 1e-6 of one that the input
/// cannot stabilise; for others the residual is some roundings.
const RESIDUAL_TOLERANCE: f64 = 1e-6;

/// Distance from the stability boundary beyond which no hidden mode is suspected. A weight that is only rounding error
/// moves a single mode off the boundary by the square root of it.
const SAFE_MARGIN: f64 = 1e-6;

/// Distance from the stability boundary at which the loop is stable beyond the rounding of its eigenvalues.
const CLEAR_MARGIN: f64 = 1e-11;

/// Newton steps after doubling. The first takes what the Cayley transform and the doublings have rounded, the second
/// verifies it.
const POLISHING_LIMIT: usize = 2;

/// Weights on every state that are tried in turn, relative to the weight that stops an unstable mode within a step. The
/// larger, the further from the solution that is requested; the smaller, the more of them drowns in rounding where inputs
/// differ in size.
const REGULARIZATIONS: [f64; 4] = [1e-3, 1.0, 1e4, 1e8];

/// Newton steps from a nearby regulator. Each at least halves the distance, and the last few square it.
const NEWTON_LIMIT: usize = 50;

/// A cost P that may solve the equation, with all that tells whether it does.
pub(super) struct Candidate {
    pub(super) cost: DMatrix<f64>,
    pub(super) gain: DMatrix<f64>,
    pub(super) eigenvalues: Vec<Complex<f64>>,
    pub(super) margin: f64,
    pub(super) residual: f64,
    pub(super) iterations: usize,
}

impl Candidate {
    fn new(riccati: &Riccati, Doubled { cost, iterations }: Doubled) -> Self {
        let gain = riccati.gain(&cost);
        let eigenvalues = stability::eigenvalues(riccati.time, &riccati.closed_loop(&gain));
        Self {
            margin: stability::margin(riccati.time, &eigenvalues),
            // A residual that is NaN is larger than any other.
            residual: riccati.relative_residual(&cost).min(f64::INFINITY),
            cost,
            gain,
            eigenvalues,
            iterations,
        }
    }

    /// Newton steps further: those of `descent` until the cost settles, then those that still lower the residual. They
    /// are defined only if the loop is stable.
    fn refined(self, riccati: &Riccati, descent: usize) -> Self {
        if self.margin <= 0.0 {
            return self;
        }
        let (settled, descended) = riccati.descend(self.cost, descent);
        let (cost, polished) = riccati.polish(settled, POLISHING_LIMIT);
        let iterations = self.iterations + descended + polished;
        Self::new(riccati, Doubled { cost, iterations })
    }

    /// Whether P solves the equation and its loop is stable by more than `margin`.
    fn solves(&self, margin: f64) -> bool {
        self.residual <= RESIDUAL_TOLERANCE && self.margin > margin
    }
}

/// The stages of the module's introduction.
pub(super) fn stabilizing_candidate(riccati: &Riccati) -> (Candidate, LqrStatus) {
    let direct = Candidate::new(riccati, riccati.solve()).refined(riccati, 0);
    if direct.solves(SAFE_MARGIN) {
        return (direct, LqrStatus::Stabilized);
    }
    let tolerances = if direct.solves(CLEAR_MARGIN) {
        stability::STRICT
    } else {
        stability::LENIENT
    };
    if let Some(eigenvalue) = stability::unreachable_mode(riccati, tolerances) {
        return (direct, LqrStatus::NotStabilizable { eigenvalue });
    }
    if let Some(eigenvalue) = stability::unobservable_mode(riccati, tolerances) {
        return (direct, LqrStatus::UnobservedMode { eigenvalue });
    }
    if direct.solves(0.0) {
        return (direct, LqrStatus::Stabilized);
    }
    match nearby_candidate(riccati) {
        Some(nearby) if nearby.solves(0.0) => (nearby, LqrStatus::Stabilized),
        _ => match reachable_decomposition::unreachable_mode(riccati) {
            Some(eigenvalue) => (direct, LqrStatus::NotStabilizable { eigenvalue }),
            None => (direct, LqrStatus::NotConverged),
        },
    }
}

/// The solution that Newton's method reaches from a stable loop for slightly different weights, the smallest that yield
/// one.
fn nearby_candidate(riccati: &Riccati) -> Option<Candidate> {
    let solve = |strength| Candidate::new(riccati, riccati.solve_regularized(strength));
    let nearby = REGULARIZATIONS
        .into_iter()
        .map(solve)
        .find(|c| c.margin > 0.0)?;
    Some(nearby.refined(riccati, NEWTON_LIMIT))
}
