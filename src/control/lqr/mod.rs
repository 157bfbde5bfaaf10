//! The infinite-horizon linear-quadratic regulator, in discrete and in continuous time.
//!
//! ```text
//!   discrete      x⁺ = A x + B u    minimise  Σ xᵀQx + uᵀRu
//!                 P = Q + AᵀPA − AᵀPB (R + BᵀPB)⁻¹ BᵀPA,    K = (R + BᵀPB)⁻¹ BᵀPA
//!   continuous    ẋ  = A x + B u    minimise  ∫ xᵀQx + uᵀRu dt
//!                 0 = Q + AᵀP + PA − PBR⁻¹BᵀP,              K = R⁻¹BᵀP
//! ```
//!
//! Of the solutions P, the one whose loop A − B K is stable is requested. The way to it:
//!
//! 1. doubling (`doubling.rs`), which finds it whenever the cost sees every mode that is not stable;
//! 2. Newton steps, which take the last digits of the residual and are kept while they help;
//! 3. if the loop is not stable, rank tests (`stability.rs`), which name the mode on the boundary that is out of reach
//!    or unobservable;
//! 4. otherwise an unstable mode is unobservable: doubling with a small weight on every state, and Newton steps from
//!    there without it;
//! 5. if that fails, too, the part that the input does not reach at all (`reachable_decomposition.rs`) may explain it:
//!    chains of equal modes hide from tests at a single eigenvalue.

mod candidate;
#[cfg(test)]
mod tests;

use std::fmt;

use nalgebra::{Cholesky, Complex, DMatrix, DVector, Dyn};

use crate::control::balance::Balance;
use crate::control::doubling::{TimeDomain, is_finite};
use crate::control::riccati::Riccati;
use crate::control::stability;
use crate::control::weights::{self, WeightDefect};
use candidate::{Candidate, stabilizing_candidate};

/// A linear-quadratic regulator u = −K x, with the residual of its Riccati equation.
///
/// Made by [`Lqr::discrete`] or [`Lqr::continuous`]. Check [`status`](Self::status): after a failed design the value contains the best iterate.
///
/// # Examples
/// ```
/// use dualbody::control::Lqr;
/// use nalgebra::dmatrix;
///
/// // A double integrator with unit weights has the gain [1, √3].
/// let (a, b) = (dmatrix![0.0, 1.0; 0.0, 0.0], dmatrix![0.0; 1.0]);
/// let lqr = Lqr::continuous(&a, &b, &dmatrix![1.0, 0.0; 0.0, 1.0], &dmatrix![1.0]);
/// assert!(lqr.is_stabilized());
/// assert!((lqr.gain - dmatrix![1.0, 3.0_f64.sqrt()]).norm() < 1e-12);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Lqr {
    /// The gain K of u = −K x, nu × nx. Zero if the data are invalid or overflow.
    pub gain: DMatrix<f64>,
    /// The symmetric matrix P of the cost xᵀ P x that remains from the state x, nx × nx. Zero if the data are invalid
    /// or overflow.
    pub cost_to_go: DMatrix<f64>,
    /// The eigenvalues of A − B K, the least stable first: by decreasing modulus (discrete) or real part (continuous).
    /// Empty if they could not be computed.
    pub closed_loop_eigenvalues: Vec<Complex<f64>>,
    /// The Frobenius norm of the Riccati equation's left side over the sum of the norms of its terms, with states
    /// scaled by powers of two so that their units do not matter; infinite if the data are invalid or overflow.
    pub residual: f64,
    /// Number of doublings and Newton steps.
    pub iterations: usize,
    /// Status of the design: the loop is stable and the gain optimal, or the reason why not.
    pub status: LqrStatus,
}

/// Termination status of the design of a regulator.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum LqrStatus {
    /// P solves the Riccati equation and A − B K is stable.
    Stabilized,
    /// An open-loop mode on or outside the stability boundary cannot be reached by the input, so that no gain
    /// stabilises it. The stored iterate is optimal for some finite horizon.
    NotStabilizable {
        /// The least stable of these modes, an eigenvalue of A.
        eigenvalue: Complex<f64>,
    },
    /// A mode on the stability boundary has no weight in the cost, so no stabilising gain is optimal. The stored iterate hardly acts on this mode.
    /// Remedy: a weight on the mode.
    UnobservedMode {
        /// The mode, an eigenvalue of A.
        eigenvalue: Complex<f64>,
    },
    /// Q is not symmetric positive semidefinite, or R is not symmetric positive definite.
    InvalidWeights {
        /// Defect, and the weight that has it.
        reason: WeightDefect,
    },
    /// An entry of A, B, Q or R is infinite or NaN.
    NotFinite,
    /// The equation is too ill-conditioned for double precision: the best iterate does not stabilise, or leaves a
    /// residual.
    NotConverged,
}

impl Lqr {
    /// Designs the regulator of x⁺ = A x + B u that minimises Σ xᵀ Q x + uᵀ R u.
    ///
    /// A and B are those of a fixed point, a state that a step leaves unchanged; the input that holds it is added to the result of
    /// [`control`](Self::control). Effort limits are ignored.
    ///
    /// Solves  P = Q + Aᵀ P A − Aᵀ P B (R + Bᵀ P B)⁻¹ Bᵀ P A  for its stabilising solution and returns
    /// K = (R + Bᵀ P B)⁻¹ Bᵀ P A. Between 5 and 30 doublings of O(nx³) each; allocates.
    ///
    /// * `a` – A, nx × nx; may be singular, unstable, badly scaled
    /// * `b` – B, nx × nu
    /// * `q` – weight on the state, nx × nx, symmetric positive semidefinite; modes that are unstable need no weight
    /// * `r` – weight on the input, nu × nu, symmetric positive definite
    ///
    /// # Limitations
    /// Stability is decided to a margin of about 1e-11 in the modulus of the eigenvalues. An unstable mode without
    /// weight that lies within 3e-8 of the unit circle counts as on it.
    ///
    /// # Panics
    /// If A is empty or not square, or if the shapes of B, Q, R do not fit it. Invalid values do not panic, but set the
    /// [`status`](Self::status).
    ///
    /// # Examples
    /// ```
    /// use dualbody::control::Lqr;
    /// use nalgebra::dmatrix;
    ///
    /// // P = 1 + P − P² / (1 + P): the golden ratio.
    /// let one = dmatrix![1.0];
    /// let lqr = Lqr::discrete(&one, &one, &one, &one);
    /// assert!((lqr.cost_to_go[0] - 1.618_033_988_75).abs() < 1e-10);
    /// ```
    ///
    /// # References
    /// [Chu, Fan, Lin and Wang 2004; Hewer 1971].
    pub fn discrete(
        a: &DMatrix<f64>,
        b: &DMatrix<f64>,
        q: &DMatrix<f64>,
        r: &DMatrix<f64>,
    ) -> Self {
        Self::design(TimeDomain::Discrete, [a, b, q, r])
    }

    /// Designs the regulator of ẋ = A x + B u that minimises ∫ xᵀ Q x + uᵀ R u dt.
    ///
    /// Solves  0 = Q + Aᵀ P + P A − P B R⁻¹ Bᵀ P  for its stabilising solution and returns K = R⁻¹ Bᵀ P. Between 5 and
    /// 30 doublings of O(nx³) each, after one inverse of size 2 nx; allocates.
    ///
    /// * `a` – A, nx × nx (1/s)
    /// * `b` – B, nx × nu
    /// * `q` – weight on the state, nx × nx, symmetric positive semidefinite; modes that are unstable need no weight
    /// * `r` – weight on the input, nu × nu, symmetric positive definite
    ///
    /// # Limitations
    /// Stability is decided to a margin of about 1e-11 of the fastest closed-loop eigenvalue. An unstable mode without
    /// weight that lies within 3e-8 of the imaginary axis, relative to the fastest mode, counts as on it.
    ///
    /// # Panics
    /// If A is empty or not square, or if the shapes of B, Q, R do not fit it. Invalid values do not panic, but set the
    /// [`status`](Self::status).
    ///
    /// # Examples
    /// ```
    /// use dualbody::control::Lqr;
    /// use nalgebra::dmatrix;
    ///
    /// // 0 = 1 − P²: the loop ẋ = −x.
    /// let lqr = Lqr::continuous(&dmatrix![0.0], &dmatrix![1.0], &dmatrix![1.0], &dmatrix![1.0]);
    /// assert!((lqr.spectral_abscissa() + 1.0).abs() < 1e-12);
    /// ```
    ///
    /// # References
    /// [Chu, Fan and Lin 2005; Kleinman 1968].
    pub fn continuous(
        a: &DMatrix<f64>,
        b: &DMatrix<f64>,
        q: &DMatrix<f64>,
        r: &DMatrix<f64>,
    ) -> Self {
        Self::design(TimeDomain::Continuous, [a, b, q, r])
    }

    /// The input u = −K x.
    ///
    /// * `x` – state (or its deviation from the operating point), length nx
    ///
    /// # Panics
    /// If `x` has the wrong length.
    pub fn control(&self, x: &DVector<f64>) -> DVector<f64> {
        let nx = self.gain.ncols();
        assert!(x.len() == nx, "the state has length {}, not {nx}", x.len());
        -(&self.gain * x)
    }

    /// Whether the design succeeded: the loop is stable and the gain optimal.
    pub fn is_stabilized(&self) -> bool {
        self.status == LqrStatus::Stabilized
    }

    /// The largest modulus of the closed-loop eigenvalues: below one, a discrete loop is stable. Not a number if the
    /// eigenvalues could not be computed.
    pub fn spectral_radius(&self) -> f64 {
        self.largest(|eigenvalue| eigenvalue.norm())
    }

    /// The largest real part of the closed-loop eigenvalues: below zero, a continuous loop is stable. Not a number if
    /// the eigenvalues could not be computed.
    pub fn spectral_abscissa(&self) -> f64 {
        self.largest(|eigenvalue| eigenvalue.re)
    }

    fn largest(&self, measure: impl Fn(&Complex<f64>) -> f64) -> f64 {
        let measures = self.closed_loop_eigenvalues.iter().map(measure);
        measures.reduce(f64::max).unwrap_or(f64::NAN)
    }

    fn design(time: TimeDomain, data: [&DMatrix<f64>; 4]) -> Self {
        assert_shapes(data);
        match Normalized::new(time, data) {
            Err(status) => Self::undesigned(time, data, status),
            Ok(problem) => {
                let (candidate, status) = stabilizing_candidate(&problem.riccati);
                let lqr = problem.restore(candidate, status);
                let overflows = !is_finite(&lqr.gain) || !is_finite(&lqr.cost_to_go);
                match status {
                    _ if !overflows => lqr,
                    LqrStatus::Stabilized => Self::undesigned(time, data, LqrStatus::NotConverged),
                    _ => Self::undesigned(time, data, status),
                }
            }
        }
    }

    /// The regulator that does nothing, for data that pose no problem or overflow.
    fn undesigned(time: TimeDomain, [a, b, ..]: [&DMatrix<f64>; 4], status: LqrStatus) -> Self {
        Self {
            gain: DMatrix::zeros(b.ncols(), b.nrows()),
            cost_to_go: DMatrix::zeros(a.nrows(), a.nrows()),
            closed_loop_eigenvalues: stability::eigenvalues(time, a),
            residual: f64::INFINITY,
            iterations: 0,
            status,
        }
    }
}

fn assert_shapes([a, b, q, r]: [&DMatrix<f64>; 4]) {
    let (nx, nu) = (a.nrows(), b.ncols());
    assert!(nx > 0 && a.is_square(), "A is {:?}, not square", a.shape());
    assert!(b.nrows() == nx, "B is {:?}, A is {nx} x {nx}", b.shape());
    assert!(
        q.shape() == (nx, nx),
        "Q is {:?}, A is {nx} x {nx}",
        q.shape()
    );
    assert!(
        r.shape() == (nu, nu),
        "R is {:?}, B has {nu} columns",
        r.shape()
    );
}

/// The equation with balanced states and unit input weight, and the way back from it.
struct Normalized {
    riccati: Riccati,
    balance: Balance,
    r: Cholesky<f64, Dyn>,
}

impl Normalized {
    /// The equation, or what forbids it.
    fn new(time: TimeDomain, [a, b, q, r]: [&DMatrix<f64>; 4]) -> Result<Self, LqrStatus> {
        if ![a, b, q, r].into_iter().all(is_finite) {
            return Err(LqrStatus::NotFinite);
        }
        let r =
            weights::input_factor(q, r).map_err(|reason| LqrStatus::InvalidWeights { reason })?;
        let riccati = Riccati::new(time, [a, b, q], &r);
        let balance = Balance::of(&riccati.triple());
        Ok(Self {
            riccati: riccati.balanced(&balance),
            balance,
            r,
        })
    }

    /// Back from x = D x̂ and û = Lᵀ u: K = L⁻ᵀ K̂ D⁻¹ and P = D⁻¹ P̂ D⁻¹.
    fn restore(&self, candidate: Candidate, status: LqrStatus) -> Lqr {
        let mut gain = self.balance.restore_gain(&candidate.gain);
        self.r.l_dirty().tr_solve_lower_triangular_mut(&mut gain);
        Lqr {
            gain,
            cost_to_go: self.balance.restore_cost(&candidate.cost),
            closed_loop_eigenvalues: candidate.eigenvalues,
            residual: candidate.residual,
            iterations: candidate.iterations,
            status,
        }
    }
}

impl fmt::Display for LqrStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stabilized => write!(f, "stabilized"),
            Self::NotStabilizable { eigenvalue } => {
                write!(
                    f,
                    "not stabilizable: the input does not reach the mode {eigenvalue:.6}"
                )
            }
            Self::UnobservedMode { eigenvalue } => write!(
                f,
                "no stabilizing solution: the cost does not see the mode {eigenvalue:.6} on the stability boundary"
            ),
            Self::InvalidWeights { reason } => write!(f, "invalid weights: {reason}"),
            Self::NotFinite => write!(f, "an entry of A, B, Q or R is not a finite number"),
            Self::NotConverged => write!(f, "not converged: the problem is too ill-conditioned"),
        }
    }
}
