//! The infinite-horizon linear-quadratic regulator, in discrete and in continuous time.
//!
//! ```text
//!   discrete      x⁺ = A x + B u    minimise  Σ xᵀQx + uᵀRu
//!                 P = Q + AᵀPA − AᵀPB (R + BᵀPB)⁻¹ BᵀPA,    K = (R + BᵀPB)⁻¹ BᵀPA
//!   continuous    ẋ  = A x + B u    minimise  ∫ xᵀQx + uᵀRu dt
//!                 0 = Q + AᵀP + PA − PBR⁻¹BᵀP,              K = R⁻¹BᵀP
//! ```
//!
//! Of the solutions P, the one whose loop A − B K is stable is wanted. The way to it:
//!
//! 1. doubling (`doubling.rs`), which finds it whenever the cost sees every mode that is not stable;
//! 2. Newton steps, which take the last digits of the residual and are kept while they help;
//! 3. if the loop is not stable, rank tests (`stability.rs`), which name the mode that is out of reach or lies unseen
//!    on the boundary;
//! 4. otherwise an unstable mode is unseen: doubling with a small weight on every state, and Newton steps from there
//!    without it;
//! 5. if that fails, too, the part that the input does not reach at all (`staircase.rs`) may explain it: chains of equal
//!    modes hide from tests at a single eigenvalue.

use std::fmt;

use nalgebra::{Cholesky, Complex, DMatrix, DVector, Dyn};

use super::balance::Balance;
use super::doubling::{Doubled, TimeDomain, is_finite};
use super::riccati::Riccati;
use super::stability;
use super::staircase;
use super::weights::{self, WeightDefect};

/// Relative residual up to which P counts as a solution. It binds for systems within about 1e-6 of one that the input
/// cannot stabilise; for others the residual is some roundings.
const RESIDUAL_TOLERANCE: f64 = 1e-6;

/// Distance from the stability boundary from which on no hidden mode is suspected. A weight that is only rounding error
/// moves a single mode off the boundary by the square root of it.
const SAFE_MARGIN: f64 = 1e-6;

/// Distance from the stability boundary at which the loop is stable beyond the rounding of its eigenvalues.
const CLEAR_MARGIN: f64 = 1e-11;

/// Newton steps after doubling. The first takes what the Cayley transform and the doublings have rounded, the second
/// verifies it.
const POLISHING_LIMIT: usize = 2;

/// Weights on every state that are tried in turn, relative to the weight that stops an unstable mode within a step. The
/// larger, the further from the solution that is wanted; the smaller, the more of them drowns in rounding where inputs
/// differ in size.
const REGULARIZATIONS: [f64; 4] = [1e-3, 1.0, 1e4, 1e8];

/// Newton steps from a nearby regulator. Each at least halves the distance, and the last few square it.
const NEWTON_LIMIT: usize = 50;

/// A linear-quadratic regulator u = −K x, with the certificate that it is one.
///
/// Made by [`Lqr::discrete`] or [`Lqr::continuous`]. Check [`status`](Self::status): a regulator that could not be made
/// is a value, too, and carries the best iterate.
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
    /// Doublings made and Newton steps kept.
    pub iterations: usize,
    /// Whether the loop is stable and optimal, or why not.
    pub status: LqrStatus,
}

/// How the design of a regulator ended.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum LqrStatus {
    /// P solves the Riccati equation and A − B K is stable.
    Stabilized,
    /// An open-loop mode on or outside the stability boundary cannot be reached by the input, so that no gain
    /// stabilises it. The iterate that is kept is optimal for some finite horizon.
    NotStabilizable {
        /// The least stable of these modes, an eigenvalue of A.
        eigenvalue: Complex<f64>,
    },
    /// A mode on the stability boundary is not seen by the cost: leaving it alone costs nothing, so no stabilising gain
    /// is optimal. The iterate that is kept leaves it (nearly) alone. A weight on that mode helps.
    UnobservedMode {
        /// The mode, an eigenvalue of A.
        eigenvalue: Complex<f64>,
    },
    /// Q is not symmetric positive semidefinite, or R is not symmetric positive definite.
    InvalidWeights {
        /// What is wrong with which weight.
        reason: WeightDefect,
    },
    /// An entry of A, B, Q or R is infinite or not a number.
    NotFinite,
    /// The equation is too ill-conditioned for double precision: the best iterate does not stabilise, or leaves a
    /// residual.
    NotConverged,
}

impl Lqr {
    /// Designs the regulator of x⁺ = A x + B u that minimises Σ xᵀ Q x + uᵀ R u.
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
    /// If A is empty or not square, or if the shapes of B, Q, R do not fit it. Bad values never panic, they are a
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
    /// If A is empty or not square, or if the shapes of B, Q, R do not fit it. Bad values never panic, they are a
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

/// A cost P that may solve the equation, with all that tells whether it does.
struct Candidate {
    cost: DMatrix<f64>,
    gain: DMatrix<f64>,
    eigenvalues: Vec<Complex<f64>>,
    margin: f64,
    residual: f64,
    iterations: usize,
}

impl Candidate {
    fn new(riccati: &Riccati, Doubled { cost, iterations }: Doubled) -> Self {
        let gain = riccati.gain(&cost);
        let eigenvalues = stability::eigenvalues(riccati.time, &riccati.closed_loop(&gain));
        Self {
            margin: stability::margin(riccati.time, &eigenvalues),
            // A residual that is not a number is larger than any other.
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
fn stabilizing_candidate(riccati: &Riccati) -> (Candidate, LqrStatus) {
    let direct = Candidate::new(riccati, riccati.solve()).refined(riccati, 0);
    if direct.solves(SAFE_MARGIN) {
        return (direct, LqrStatus::Stabilized);
    }
    let scrutiny = if direct.solves(CLEAR_MARGIN) {
        stability::STRICT
    } else {
        stability::LENIENT
    };
    if let Some(eigenvalue) = stability::unreachable_mode(riccati, scrutiny) {
        return (direct, LqrStatus::NotStabilizable { eigenvalue });
    }
    if let Some(eigenvalue) = stability::unseen_mode(riccati, scrutiny) {
        return (direct, LqrStatus::UnobservedMode { eigenvalue });
    }
    if direct.solves(0.0) {
        return (direct, LqrStatus::Stabilized);
    }
    match nearby_candidate(riccati) {
        Some(nearby) if nearby.solves(0.0) => (nearby, LqrStatus::Stabilized),
        _ => match staircase::unreachable_mode(riccati) {
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

#[cfg(test)]
mod tests {
    use super::super::doubling::symmetrized;
    use super::*;
    use approx::assert_relative_eq;
    use nalgebra::{dmatrix, dvector};
    use proptest::prelude::*;
    use proptest::test_runner::{Config, RngSeed};

    /// The same solution by another formula: the digits that a well-conditioned problem keeps.
    const OTHER_FORMULA: f64 = 1e-12;

    /// Residual of a random problem, relative: its conditioning takes some digits.
    const RANDOM_RESIDUAL: f64 = 1e-9;

    type Design = fn(&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>) -> Lqr;

    const BOTH_TIMES: [(TimeDomain, Design); 2] = [
        (TimeDomain::Discrete, Lqr::discrete),
        (TimeDomain::Continuous, Lqr::continuous),
    ];

    fn scalar(design: Design, [a, b, q, r]: [f64; 4]) -> Lqr {
        let [a, b, q, r] = [a, b, q, r].map(|x| dmatrix![x]);
        design(&a, &b, &q, &r)
    }

    fn diagonal(entries: &[f64]) -> DMatrix<f64> {
        DMatrix::from_diagonal(&DVector::from_column_slice(entries))
    }

    /// A random system in which Q = Cᵀ C has half the rank of the state.
    #[derive(Clone, Debug)]
    struct Problem {
        a: DMatrix<f64>,
        b: DMatrix<f64>,
        q: DMatrix<f64>,
        r: DMatrix<f64>,
    }

    impl Problem {
        fn solve(&self, design: Design) -> Lqr {
            design(&self.a, &self.b, &self.q, &self.r)
        }

        /// The Riccati equation as the textbook has it, relative to its largest term.
        fn textbook_residual(&self, time: TimeDomain, p: &DMatrix<f64>) -> f64 {
            let Self { a, b, q, r } = self;
            let (at, bt) = (a.transpose(), b.transpose());
            let inverse = |m: DMatrix<f64>| m.try_inverse().unwrap();
            let terms = match time {
                TimeDomain::Discrete => {
                    let gain = inverse(r + &bt * p * b) * &bt * p * a;
                    [q.clone(), &at * p * a, -(&at * p * b * gain), -p]
                }
                TimeDomain::Continuous => {
                    let quadratic = p * b * inverse(r.clone()) * &bt * p;
                    [q.clone(), &at * p, p * a, -quadratic]
                }
            };
            let size = terms.iter().map(DMatrix::norm).fold(0.0, f64::max);
            terms.iter().sum::<DMatrix<f64>>().norm() / size
        }

        /// The cost matrix of running u = −K x for ever: Σ Āᵏᵀ (Q + Kᵀ R K) Āᵏ with Ā = A − B K.
        fn cost_of(&self, gain: &DMatrix<f64>) -> DMatrix<f64> {
            let closed = &self.a - &self.b * gain;
            let mut term = &self.q + gain.transpose() * &self.r * gain;
            let mut sum = term.clone();
            for _ in 0..100_000 {
                term = closed.transpose() * term * &closed;
                sum += &term;
                if term.norm() <= 1e-18 * sum.norm() {
                    return sum;
                }
            }
            panic!("the loop is not stable enough to sum its cost");
        }
    }

    fn entries(nrows: usize, ncols: usize) -> impl Strategy<Value = DMatrix<f64>> {
        prop::collection::vec(-1.0..1.0, nrows * ncols)
            .prop_map(move |v| DMatrix::from_vec(nrows, ncols, v))
    }

    /// Random systems, stable or not: entries of A of size 2 / √nx give a spectral radius around one.
    fn problems(nx: usize, nu: usize) -> impl Strategy<Value = Problem> {
        let size = 2.0 / (nx as f64).sqrt();
        let parts = (
            entries(nx, nx),
            entries(nx, nu),
            entries(nx.div_ceil(2), nx),
            entries(nu, nu),
        );
        parts.prop_map(move |(a, b, c, d)| Problem {
            a: a * size,
            b,
            q: c.transpose() * &c,
            r: d.transpose() * &d + DMatrix::identity(nu, nu),
        })
    }

    fn fixed_seed(cases: u32) -> Config {
        Config {
            cases,
            rng_seed: RngSeed::Fixed(7),
            failure_persistence: None,
            ..Config::default()
        }
    }

    fn one_problem(nx: usize, nu: usize) -> Problem {
        use proptest::strategy::ValueTree;
        let mut runner = proptest::test_runner::TestRunner::new(fixed_seed(1));
        problems(nx, nu).new_tree(&mut runner).unwrap().current()
    }

    /// A fixed well-conditioned change of coordinates, to hide the structure of diagonal systems.
    fn mixed(nx: usize) -> DMatrix<f64> {
        DMatrix::from_fn(nx, nx, |i, j| {
            if i == j {
                2.0
            } else {
                1.0 / (1.0 + (i + 2 * j) as f64)
            }
        })
    }

    /// A system with the given modes, input and weight, in mixed coordinates.
    fn modal(modes: &[f64], b: &DMatrix<f64>, q: &DMatrix<f64>) -> Problem {
        let t = mixed(modes.len());
        let inverse = t.clone().try_inverse().unwrap();
        Problem {
            a: &t * diagonal(modes) * &inverse,
            b: &t * b,
            q: symmetrized(inverse.transpose() * q * &inverse),
            r: DMatrix::identity(b.ncols(), b.ncols()),
        }
    }

    // With x⁺ = a x + b u: b² P² + (r − a² r − b² q) P − q r = 0.
    #[test]
    fn scalar_dare_equals_closed_form() {
        for [a, b, q, r] in [
            [1.0, 1.0, 1.0, 1.0],
            [1.5, 0.1, 2.0, 3.0],
            [-0.7, 2.0, 0.3, 1e-3],
            [0.0, 1.0, 5.0, 1.0],
            [20.0, 1e-3, 1.0, 1.0],
        ] {
            let half = 0.5 * (r - a * a * r - b * b * q);
            let p = (f64::hypot(half, (b * b * q * r).sqrt()) - half) / (b * b);
            let lqr = scalar(Lqr::discrete, [a, b, q, r]);
            assert!(lqr.is_stabilized());
            assert_relative_eq!(lqr.cost_to_go[0], p, max_relative = OTHER_FORMULA);
            let gain = a * b * p / (r + b * b * p);
            assert_relative_eq!(lqr.gain[0], gain, max_relative = OTHER_FORMULA);
        }
    }

    // With ẋ = a x + b u: P = (a + √(a² + b² q / r)) r / b², and the loop is ẋ = −√(a² + b² q / r) x.
    #[test]
    fn scalar_care_equals_closed_form() {
        for [a, b, q, r] in [
            [1.0, 1.0, 1.0, 1.0],
            [1.5, 0.1, 2.0, 3.0],
            [-0.7, 2.0, 30.0, 1e-3],
            [0.0, 1.0, 5.0, 1.0],
            [2e4, 1e-3, 1.0, 1.0],
        ] {
            let pole = f64::hypot(a, (b * b * q / r).sqrt());
            let lqr = scalar(Lqr::continuous, [a, b, q, r]);
            assert!(lqr.is_stabilized());
            let p = (a + pole) * r / (b * b);
            assert_relative_eq!(lqr.cost_to_go[0], p, max_relative = OTHER_FORMULA);
            assert_relative_eq!(lqr.spectral_abscissa(), -pole, max_relative = OTHER_FORMULA);
        }
    }

    // K = [1, √3], P = [√3, 1; 1, √3], poles (−√3 ± i) / 2.
    #[test]
    fn double_integrator_equals_closed_form() {
        let (a, b) = (dmatrix![0.0, 1.0; 0.0, 0.0], dmatrix![0.0; 1.0]);
        let lqr = Lqr::continuous(&a, &b, &DMatrix::identity(2, 2), &dmatrix![1.0]);
        let root = 3.0_f64.sqrt();
        assert_relative_eq!(lqr.gain, dmatrix![1.0, root], epsilon = 1e-14);
        assert_relative_eq!(
            lqr.cost_to_go,
            dmatrix![root, 1.0; 1.0, root],
            epsilon = 1e-14
        );
        let pole = lqr.closed_loop_eigenvalues[0];
        assert_relative_eq!(pole.re, -0.5 * root, epsilon = 1e-14);
        assert_relative_eq!(pole.im, 0.5, epsilon = 1e-14);
    }

    // The loop is the Butterworth filter s² + √2 ω s + ω² with ω = r^(−1/4), so K = [ω², √2 ω].
    #[test]
    fn position_weighted_double_integrator_equals_closed_form() {
        let (a, b) = (dmatrix![0.0, 1.0; 0.0, 0.0], dmatrix![0.0; 1.0]);
        for r in [1e-8, 1.0, 1e8] {
            let lqr = Lqr::continuous(&a, &b, &diagonal(&[1.0, 0.0]), &dmatrix![r]);
            let expected = dmatrix![r.powf(-0.5), 2.0_f64.sqrt() * r.powf(-0.25)];
            assert!(lqr.is_stabilized());
            assert_relative_eq!(lqr.gain[0], expected[0], max_relative = OTHER_FORMULA);
            assert_relative_eq!(lqr.gain[1], expected[1], max_relative = OTHER_FORMULA);
        }
    }

    fn check_solution(problem: &Problem) {
        for (time, design) in BOTH_TIMES {
            let lqr = problem.solve(design);
            let nx = problem.a.nrows();
            assert!(
                lqr.is_stabilized(),
                "{time:?} nx {nx}: {} {problem:?}",
                lqr.status
            );
            let residual = problem.textbook_residual(time, &lqr.cost_to_go);
            assert!(
                residual < RANDOM_RESIDUAL,
                "{time:?} nx {nx}: residual {residual:e}"
            );
            assert!(
                lqr.residual < RANDOM_RESIDUAL,
                "{time:?} nx {nx}: {:e}",
                lqr.residual
            );
            assert_eq!(lqr.cost_to_go, lqr.cost_to_go.transpose());
            match time {
                TimeDomain::Discrete => assert!(lqr.spectral_radius() < 1.0),
                TimeDomain::Continuous => assert!(lqr.spectral_abscissa() < 0.0),
            }
        }
    }

    proptest! {
        #![proptest_config(fixed_seed(40))]

        #[test]
        fn riccati_residual_vanishes_and_the_loop_is_stable(
            problem in (1..12_usize).prop_flat_map(|nx| problems(nx, 1 + nx / 3))
        ) {
            check_solution(&problem);
        }

        #[test]
        fn cost_to_go_equals_the_summed_cost_of_the_loop(problem in problems(5, 2)) {
            let lqr = problem.solve(Lqr::discrete);
            let summed = problem.cost_of(&lqr.gain);
            prop_assert!((&summed - &lqr.cost_to_go).norm() <= 1e-9 * summed.norm());
        }

        #[test]
        fn perturbed_gain_costs_at_least_as_much(problem in problems(4, 2), change in entries(2, 4)) {
            let lqr = problem.solve(Lqr::discrete);
            // Small enough for the perturbed loop to be stable.
            let step = 0.1 * (1.0 - lqr.spectral_radius()) / (1.0 + problem.b.norm());
            let perturbed = problem.cost_of(&(&lqr.gain + change * step));
            let excess = (perturbed - &lqr.cost_to_go).symmetric_eigenvalues();
            prop_assert!(excess.min() >= -1e-9 * lqr.cost_to_go.norm(), "{}", excess);
        }
    }

    #[test]
    fn riccati_residual_vanishes_for_large_systems() {
        for (nx, nu) in [(30, 4), (70, 8)] {
            check_solution(&one_problem(nx, nu));
        }
    }

    #[test]
    fn cost_to_go_equals_the_simulated_cost() {
        let problem = one_problem(6, 2);
        let lqr = problem.solve(Lqr::discrete);
        let start = DVector::from_fn(6, |i, _| 1.0 - 0.3 * i as f64);
        let (mut x, mut cost) = (start.clone(), 0.0);
        for _ in 0..5000 {
            let u = lqr.control(&x);
            cost += x.dot(&(&problem.q * &x)) + u.dot(&(&problem.r * &u));
            x = &problem.a * x + &problem.b * u;
        }
        let expected = start.dot(&(&lqr.cost_to_go * &start));
        assert_relative_eq!(cost, expected, max_relative = 1e-10);
    }

    // x⁺ = (I + A dt) x + B dt u at the cost dt (xᵀQx + uᵀRu): the error of the gain is O(dt).
    #[test]
    fn continuous_gain_equals_the_limit_of_the_discrete_gain() {
        let Problem { a, b, q, r } = one_problem(4, 2);
        let limit = Lqr::continuous(&a, &b, &q, &r).gain;
        let error = |dt: f64| {
            let step = DMatrix::identity(4, 4) + &a * dt;
            let gain = Lqr::discrete(&step, &(&b * dt), &(&q * dt), &(&r * dt)).gain;
            (gain - &limit).norm()
        };
        assert!(error(1e-6) < 1e-4 * limit.norm());
        assert_relative_eq!(error(1e-4) / error(5e-5), 2.0, max_relative = 0.02);
    }

    // A cart with a pole, linearised upright, one Euler step of dt: ẍ = u, θ̈ = g θ + u (in suitable units).
    #[test]
    fn badly_scaled_cart_pole_equals_the_same_in_other_units() {
        let dt = 1e-3;
        let a = DMatrix::identity(4, 4)
            + dmatrix![
                0.0, 0.0, 1.0, 0.0;
                0.0, 0.0, 0.0, 1.0;
                0.0, 0.98, 0.0, 0.0;
                0.0, 21.6, 0.0, 0.0
            ] * dt;
        let b = dmatrix![0.0; 0.0; 1.0; 2.0] * dt;
        let q = diagonal(&[1.0, 1000.0, 1.0, 10.0]);
        let units = diagonal(&[1e-6, 1e3, 1e5, 1e-4]);
        let inverse = units.clone().try_inverse().unwrap();
        let r = dmatrix![1e-3];
        let lqr = Lqr::discrete(&a, &b, &q, &r);
        let scaled = Lqr::discrete(
            &(&inverse * &a * &units),
            &(&inverse * &b),
            &(&units * &q * &units),
            &r,
        );
        assert!(lqr.is_stabilized() && scaled.is_stabilized());
        assert!(lqr.residual < 1e-14 && scaled.residual < 1e-14);
        assert_relative_eq!(scaled.gain * inverse, lqr.gain, max_relative = 1e-9);
    }

    // Golden numbers: scipy 1.17.1 `solve_continuous_are` and `solve_discrete_are` for this system with R = 10⁻³; the
    // first gain of the continuous regulator is −√(q₁ / r) exactly.
    #[test]
    fn cart_pole_gains_equal_those_of_scipy() {
        let a = dmatrix![
            0.0, 0.0, 1.0, 0.0;
            0.0, 0.0, 0.0, 1.0;
            0.0, 0.981, 0.0, 0.0;
            0.0, 21.58, 0.0, 0.0
        ];
        let (b, dt) = (dmatrix![0.0; 0.0; 1.0; 2.0], 1e-3);
        let (q, r) = (diagonal(&[1.0, 1000.0, 1.0, 10.0]), dmatrix![1e-3]);
        let continuous = Lqr::continuous(&a, &b, &q, &r).gain;
        let discrete = Lqr::discrete(&(DMatrix::identity(4, 4) + &a * dt), &(&b * dt), &q, &r).gain;
        let expected = [
            [
                -31.6227766016839,
                1121.46461699713,
                -90.3399355977239,
                151.732875176127,
            ],
            [
                -28.4314603555294,
                1010.59372267868,
                -81.2806010081176,
                137.459844587971,
            ],
        ];
        assert_relative_eq!(continuous[0], -1000.0_f64.sqrt(), max_relative = 1e-13);
        for (gain, golden) in [continuous, discrete].iter().zip(expected) {
            assert_relative_eq!(gain.as_slice(), golden.as_slice(), max_relative = 1e-10);
        }
    }

    // Without any cost on the state the cheapest stable loop mirrors the unstable modes: λ → 1/λ, or λ → −λ.
    #[test]
    fn unweighted_unstable_modes_equal_their_mirror_images() {
        let b = dmatrix![1.0; 1.0; 1.0];
        let problem = modal(&[2.0, -0.5, 1.25], &b, &DMatrix::zeros(3, 3));
        for (design, expected) in [
            (Lqr::discrete as Design, [0.8, 0.5, -0.5]),
            (Lqr::continuous as Design, [-0.5, -1.25, -2.0]),
        ] {
            let lqr = problem.solve(design);
            assert!(lqr.is_stabilized(), "{}", lqr.status);
            let mut found: Vec<_> = lqr.closed_loop_eigenvalues.iter().map(|z| z.re).collect();
            found.sort_by(|x, y| y.total_cmp(x));
            assert_relative_eq!(found.as_slice(), expected.as_slice(), max_relative = 1e-10);
        }
    }

    #[test]
    fn unweighted_unstable_modes_of_unequal_inputs_equal_their_mirror_images() {
        for weak in [1e-2, 1e-4, 1e-6] {
            let (a, b) = (diagonal(&[2.0, 4.0]), diagonal(&[1.0, weak]));
            let lqr = Lqr::discrete(&a, &b, &DMatrix::zeros(2, 2), &DMatrix::identity(2, 2));
            assert!(lqr.is_stabilized(), "{weak}: {}", lqr.status);
            let moduli: Vec<_> = lqr
                .closed_loop_eigenvalues
                .iter()
                .map(|z| z.norm())
                .collect();
            assert_relative_eq!(
                moduli.as_slice(),
                [0.5, 0.25].as_slice(),
                max_relative = 1e-10
            );
        }
    }

    #[test]
    fn partly_weighted_unstable_system_is_stabilized() {
        // The weight sees the first mode only.
        let problem = modal(
            &[1.1, 1.3, 0.5],
            &dmatrix![1.0; 1.0; 1.0],
            &diagonal(&[1.0, 0.0, 0.0]),
        );
        for (time, design) in BOTH_TIMES {
            let lqr = problem.solve(design);
            assert!(lqr.is_stabilized(), "{time:?}: {}", lqr.status);
            assert!(problem.textbook_residual(time, &lqr.cost_to_go) < RANDOM_RESIDUAL);
        }
    }

    // x⁺ = shift of x: dead-beat states, all eigenvalues zero. The input adds nothing but cost.
    #[test]
    fn shift_register_cost_equals_one_per_remaining_step() {
        let a = DMatrix::from_fn(5, 5, |i, j| if i == j + 1 { 1.0 } else { 0.0 });
        let b = DMatrix::from_fn(5, 1, |i, _| if i == 0 { 1.0 } else { 0.0 });
        let lqr = Lqr::discrete(&a, &b, &DMatrix::identity(5, 5), &dmatrix![1.0]);
        assert!(lqr.is_stabilized());
        assert_relative_eq!(
            lqr.cost_to_go,
            diagonal(&[5.0, 4.0, 3.0, 2.0, 1.0]),
            epsilon = 1e-14
        );
        assert_eq!(lqr.gain.norm(), 0.0);
    }

    #[test]
    fn unreachable_stable_mode_is_kept_by_the_loop() {
        let b = dmatrix![1.0; 0.0];
        let discrete = modal(&[1.5, 0.9], &b, &DMatrix::identity(2, 2)).solve(Lqr::discrete);
        assert!(discrete.is_stabilized());
        assert_relative_eq!(
            discrete.spectral_radius(),
            0.9,
            max_relative = OTHER_FORMULA
        );
        let continuous = modal(&[1.5, -0.1], &b, &DMatrix::identity(2, 2)).solve(Lqr::continuous);
        assert!(continuous.is_stabilized());
        assert_relative_eq!(
            continuous.spectral_abscissa(),
            -0.1,
            max_relative = OTHER_FORMULA
        );
    }

    #[test]
    fn not_stabilizable_names_the_unreachable_eigenvalue() {
        let b = dmatrix![1.0; 0.0; 1.0];
        for (design, mode, others) in [
            (Lqr::discrete as Design, 1.2, [3.0, 0.5]),
            (Lqr::discrete as Design, 1.0, [3.0, 0.5]),
            (Lqr::discrete as Design, -1.0, [3.0, 0.5]),
            (Lqr::continuous as Design, 0.3, [1.0, -1.0]),
            (Lqr::continuous as Design, 0.0, [1.0, -1.0]),
        ] {
            let modes = [others[0], mode, others[1]];
            for q in [DMatrix::identity(3, 3), diagonal(&[1.0, 0.0, 1.0])] {
                let lqr = modal(&modes, &b, &q).solve(design);
                let LqrStatus::NotStabilizable { eigenvalue } = lqr.status else {
                    panic!("mode {mode}: {}", lqr.status);
                };
                assert!(
                    (eigenvalue - mode).norm() < 1e-10,
                    "{eigenvalue} for {mode}"
                );
                assert!(lqr.gain.iter().all(|k| k.is_finite()) && !lqr.is_stabilized());
            }
        }
    }

    #[test]
    fn not_stabilizable_names_an_unreachable_oscillation() {
        // A rotation by 0.7 that grows by a tenth per step, beside a reachable integrator.
        let (s, c) = 0.7_f64.sin_cos();
        let a = dmatrix![1.1 * c, -1.1 * s, 0.0; 1.1 * s, 1.1 * c, 0.0; 0.0, 0.0, 1.0];
        let b = dmatrix![0.0; 0.0; 1.0];
        let lqr = Lqr::discrete(&a, &b, &DMatrix::identity(3, 3), &dmatrix![1.0]);
        let LqrStatus::NotStabilizable { eigenvalue } = lqr.status else {
            panic!("{}", lqr.status);
        };
        assert!(
            (eigenvalue - Complex::from_polar(1.1, 0.7)).norm() < 1e-12,
            "{eigenvalue}"
        );
    }

    #[test]
    fn unobserved_mode_names_the_boundary_eigenvalue() {
        let b = dmatrix![1.0; 1.0; 1.0];
        let q = diagonal(&[1.0, 0.0, 1.0]);
        for (design, modes) in [
            (Lqr::discrete as Design, [2.0, 1.0, 0.5]),
            (Lqr::discrete as Design, [0.9, -1.0, 0.5]),
            (Lqr::continuous as Design, [2.0, 0.0, -0.5]),
        ] {
            let lqr = modal(&modes, &b, &q).solve(design);
            let LqrStatus::UnobservedMode { eigenvalue } = lqr.status else {
                panic!(
                    "{modes:?}: {} {:?}",
                    lqr.status, lqr.closed_loop_eigenvalues
                );
            };
            assert!((eigenvalue - modes[1]).norm() < 1e-10, "{eigenvalue}");
        }
    }

    #[test]
    fn velocity_weight_alone_leaves_the_position_unobserved() {
        let (a, b) = (dmatrix![1.0, 0.1; 0.0, 1.0], dmatrix![0.005; 0.1]);
        let lqr = Lqr::discrete(&a, &b, &diagonal(&[0.0, 1.0]), &dmatrix![1.0]);
        assert!(
            matches!(lqr.status, LqrStatus::UnobservedMode { .. }),
            "{}",
            lqr.status
        );
        let lqr = Lqr::discrete(&a, &b, &diagonal(&[1.0, 0.0]), &dmatrix![1.0]);
        assert!(lqr.is_stabilized(), "{}", lqr.status);
    }

    #[test]
    fn each_weight_defect_is_named() {
        let (a, b, one) = (
            DMatrix::identity(2, 2),
            DMatrix::identity(2, 2),
            DMatrix::identity(2, 2),
        );
        let skewed = dmatrix![1.0, 0.1; 0.0, 1.0];
        for (q, r, reason) in [
            (&skewed, &one, WeightDefect::StateNotSymmetric),
            (
                &diagonal(&[1.0, -1e-3]),
                &one,
                WeightDefect::StateIndefinite,
            ),
            (&one, &skewed, WeightDefect::InputNotSymmetric),
            (
                &one,
                &diagonal(&[1.0, 0.0]),
                WeightDefect::InputNotPositiveDefinite,
            ),
            (
                &one,
                &dmatrix![1.0, 1.0; 1.0, 1.0],
                WeightDefect::InputNotPositiveDefinite,
            ),
            (
                &one,
                &diagonal(&[1.0, -1.0]),
                WeightDefect::InputNotPositiveDefinite,
            ),
        ] {
            let lqr = Lqr::discrete(&a, &b, q, r);
            assert_eq!(lqr.status, LqrStatus::InvalidWeights { reason });
            assert_eq!((lqr.gain.shape(), lqr.residual), ((2, 2), f64::INFINITY));
        }
    }

    #[test]
    fn not_a_number_or_infinity_in_any_argument_gives_not_finite() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for position in 0..4 {
                for (_, design) in BOTH_TIMES {
                    let mut data = [0.5, 1.0, 1.0, 1.0];
                    data[position] = bad;
                    assert_eq!(scalar(design, data).status, LqrStatus::NotFinite);
                }
            }
        }
    }

    #[test]
    fn overflowing_data_give_not_converged_and_finite_matrices() {
        for (_, design) in BOTH_TIMES {
            let lqr = scalar(design, [1e300; 4]);
            assert_eq!(lqr.status, LqrStatus::NotConverged);
            assert!(lqr.gain[0].is_finite() && lqr.cost_to_go[0].is_finite());
        }
    }

    #[test]
    fn system_without_input_is_stabilized_exactly_if_it_is_stable() {
        let (b, r) = (DMatrix::zeros(1, 0), DMatrix::zeros(0, 0));
        let lqr = |a: f64| Lqr::discrete(&dmatrix![a], &b, &dmatrix![1.0], &r);
        // P = 1 / (1 − a²)
        assert_relative_eq!(lqr(0.5).cost_to_go[0], 4.0 / 3.0, max_relative = 1e-14);
        assert!(lqr(0.5).is_stabilized());
        assert!(matches!(lqr(1.5).status, LqrStatus::NotStabilizable { .. }));
    }

    #[test]
    fn control_equals_minus_gain_times_state() {
        let lqr = scalar(Lqr::continuous, [1.0, 1.0, 3.0, 1.0]);
        assert_relative_eq!(lqr.control(&dvector![2.0])[0], -6.0, max_relative = 1e-14);
    }

    #[test]
    fn status_texts_name_the_cause() {
        let eigenvalue = Complex::new(1.5, 0.0);
        for (status, text) in [
            (LqrStatus::Stabilized, "stabilized"),
            (LqrStatus::NotStabilizable { eigenvalue }, "mode 1.5"),
            (LqrStatus::UnobservedMode { eigenvalue }, "mode 1.5"),
            (
                LqrStatus::InvalidWeights {
                    reason: WeightDefect::StateIndefinite,
                },
                "Q is not positive semidefinite",
            ),
            (LqrStatus::NotFinite, "finite"),
            (LqrStatus::NotConverged, "not converged"),
        ] {
            assert!(status.to_string().contains(text), "{status}");
        }
    }

    #[test]
    #[should_panic(expected = "Q is (1, 1), A is 2 x 2")]
    fn weight_of_the_wrong_size_panics() {
        let two = DMatrix::identity(2, 2);
        Lqr::discrete(&two, &two, &dmatrix![1.0], &two);
    }
}
