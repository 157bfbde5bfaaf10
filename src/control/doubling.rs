//! The structure-preserving doubling algorithm: one core for Riccati and Lyapunov equations in both times.
//!
//! The discrete algebraic Riccati equation  P = H + Aᵀ P (I + G P)⁻¹ A  with G = B R⁻¹ Bᵀ and H = Q is the fixed point
//! of the value iteration P ← H + Aᵀ P (I + G P)⁻¹ A. Two such steps are again one step of the same form, with
//!
//! ```text
//!   A⁺ = A (I + G H)⁻¹ A                    (1)
//!   G⁺ = G + A (I + G H)⁻¹ G Aᵀ             (2)
//!   H⁺ = H + Aᵀ H (I + G H)⁻¹ A             (3)
//! ```
//!
//! so after k doublings H is the cost of a horizon of 2ᵏ steps, and it converges quadratically to P. With G = 0 the
//! same lines are Smith's squared iteration for the Lyapunov equation P = H + Aᵀ P A. A continuous equation is brought
//! into this form by a Cayley transform, which keeps the solution P.
//!
//! # References
//! [Chu, Fan, Lin and Wang 2004] in discrete time, [Chu, Fan and Lin 2005] in continuous time; [Smith 1968].

use nalgebra::DMatrix;

use super::balance::Balance;
use super::triple::Triple;
use crate::scalar::MapEach;

/// Doublings before giving up. 2⁶⁰ steps reach the end of the slowest mode that double precision tells from one that
/// stays.
const DOUBLING_LIMIT: usize = 60;

/// Relative change of every column at which the cost has settled: a few roundings.
const SETTLED: f64 = 4.0 * f64::EPSILON;

/// Growth of the cost over the weights beyond which an iterate that never settles is not worth keeping: its rounding
/// errors would show in the gain.
const GROWTH_LIMIT: f64 = 1e8;

/// Smallest shift of the Cayley transform relative to the size of the Hamiltonian. It binds when the Hamiltonian is
/// singular.
const SHIFT_FLOOR: f64 = 1e-6;

/// Factors on the shift that are tried. More than one, because the shift may coincide with an eigenvalue of A.
const SHIFT_FACTORS: [f64; 4] = [1.0, 1.25, 0.8, 1.6];

/// Whether time runs in steps, x⁺ = A x + B u, or continuously, ẋ = A x + B u.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TimeDomain {
    /// x⁺ = A x + B u; stable inside the unit circle.
    Discrete,
    /// ẋ = A x + B u; stable in the left half plane.
    Continuous,
}

/// Result of the doubling.
#[derive(Clone, Debug)]
pub(super) struct Doubled {
    /// The symmetric cost P.
    pub(super) cost: DMatrix<f64>,
    /// Doublings made.
    pub(super) iterations: usize,
}

/// Solves P = H + Aᵀ P (I + G P)⁻¹ A, or Aᵀ P + P A − P G P + H = 0.
///
/// Where no stabilising solution is reached the last iterate of moderate size is returned; the caller judges it by its
/// residual.
pub(super) fn solve(time: TimeDomain, triple: &Triple) -> Doubled {
    let balance = Balance::of(triple);
    let scaled = balance.apply(triple);
    let doubled = match time {
        TimeDomain::Discrete => double(scaled),
        TimeDomain::Continuous => scaled.cayley().map_or_else(|| unsolved(&scaled), double),
    };
    Doubled {
        cost: balance.restore_cost(&doubled.cost),
        ..doubled
    }
}

/// Solves P = H + Aᵀ P A, or Aᵀ P + P A + H = 0, for a stable A.
pub(super) fn solve_lyapunov(time: TimeDomain, a: DMatrix<f64>, h: DMatrix<f64>) -> DMatrix<f64> {
    let g = DMatrix::zeros(a.nrows(), a.nrows());
    solve(time, &Triple { a, g, h }).cost
}

fn double(mut triple: Triple) -> Doubled {
    let growth_limit = GROWTH_LIMIT * triple.h.norm();
    let mut kept = unsolved(&triple);
    for iterations in 1..=DOUBLING_LIMIT {
        let Some(next) = triple.doubled() else {
            break;
        };
        let settled = columns_agree(&next.h, &triple.h);
        triple = next;
        if settled || triple.h.norm() <= growth_limit {
            let cost = triple.h.clone();
            kept = Doubled { cost, iterations };
        }
        if settled {
            break;
        }
    }
    kept
}

fn unsolved(triple: &Triple) -> Doubled {
    Doubled {
        cost: triple.h.clone(),
        iterations: 0,
    }
}

impl Triple {
    /// Equations (1) to (3), or `None` where they overflow.
    fn doubled(&self) -> Option<Self> {
        let n = self.a.nrows();
        let lu = (DMatrix::identity(n, n) + &self.g * &self.h).lu();
        let step = lu.solve(&self.a)?;
        let input = lu.solve(&self.g)?;
        let at = self.a.transpose();
        let next = Self {
            a: &self.a * &step,
            g: symmetrized(&self.g + &self.a * input * &at),
            h: symmetrized(&self.h + at * (&self.h * step)),
        };
        next.is_finite().then_some(next)
    }

    /// Whether all norms are numbers: stricter than the entries, because overflow ends here.
    fn is_finite(&self) -> bool {
        [&self.a, &self.g, &self.h]
            .into_iter()
            .all(|m| m.norm().is_finite())
    }

    /// The discrete equation with the same solution.
    ///
    /// The Hamiltonian ℋ = [A −G; −H −Aᵀ] has the invariant subspace [I; P], and so has (ℋ − γ)⁻¹ (ℋ + γ), which is
    /// stable on it. Written as a triple it is read off one inverse,
    ///
    /// ```text
    ///   T = [A − γ, −G; −H, γ − Aᵀ]⁻¹,    A₀ = I + 2γ T₁₁,    G₀ = −2γ T₁₂,    H₀ = −2γ T₂₁
    /// ```
    ///
    /// which exists even where γ is an eigenvalue of A, as long as that mode is reached or seen.
    fn cayley(&self) -> Option<Self> {
        let n = self.a.nrows();
        let (shift, t) = self.conditioned_shift()?;
        let t = t * (2.0 * shift);
        let block = |i, j| t.view((i * n, j * n), (n, n)).into_owned();
        let discrete = Self {
            a: DMatrix::identity(n, n) + block(0, 0),
            g: symmetrized(-block(0, 1)),
            h: symmetrized(-block(1, 0)),
        };
        discrete.is_finite().then_some(discrete)
    }

    /// The shift γ and the inverse T, the best conditioned of the candidates.
    fn conditioned_shift(&self) -> Option<(f64, DMatrix<f64>)> {
        let mut best: Option<(f64, f64, DMatrix<f64>)> = None;
        let center = self.shift();
        for shift in SHIFT_FACTORS.map_each(|factor| factor * center) {
            let shifted = self.shifted_hamiltonian(shift);
            let size = shifted.norm();
            let Some(inverse) = shifted.lu().try_inverse() else {
                continue;
            };
            let condition = size * inverse.norm();
            if condition.is_finite() && best.as_ref().is_none_or(|b| condition < b.0) {
                best = Some((condition, shift, inverse));
            }
        }
        best.map(|(_, shift, inverse)| (shift, inverse))
    }

    /// γ = |det ℋ|^(1/2n): the geometric mean of the moduli of the closed-loop eigenvalues, which are those of ℋ up to
    /// sign.
    fn shift(&self) -> f64 {
        let hamiltonian = self.shifted_hamiltonian(0.0);
        let size = hamiltonian.norm();
        if size == 0.0 {
            return 1.0;
        }
        let pivots = hamiltonian.lu().u().diagonal();
        let mean_log = pivots.map(|pivot| pivot.abs().ln()).mean();
        mean_log.exp().max(SHIFT_FLOOR * size)
    }

    /// [A − γ, −G; −H, γ − Aᵀ].
    fn shifted_hamiltonian(&self, shift: f64) -> DMatrix<f64> {
        let n = self.a.nrows();
        let shifted = &self.a - DMatrix::identity(n, n) * shift;
        let mut m = DMatrix::zeros(2 * n, 2 * n);
        m.view_mut((0, 0), (n, n)).copy_from(&shifted);
        m.view_mut((0, n), (n, n)).copy_from(&-&self.g);
        m.view_mut((n, 0), (n, n)).copy_from(&-&self.h);
        m.view_mut((n, n), (n, n)).copy_from(&-shifted.transpose());
        m
    }

    /// Returns the problem with an additional weight on every state, so that the cost sees every mode.
    ///
    /// In balanced coordinates the weight is w I with w |G| = `strength` |A|²: relative to what it takes to stop an
    /// unstable mode, whatever H is.
    pub(super) fn regularized(&self, strength: f64) -> Self {
        let n = self.a.nrows();
        let unweighted = Self {
            h: DMatrix::zeros(n, n),
            ..self.clone()
        };
        let balance = Balance::of(&unweighted);
        let [a, g] = [balance.state_map(&self.a), balance.apply(self).g].map(|m| m.amax());
        let weight = if g > 0.0 { strength * a * a / g } else { 0.0 };
        let extra = balance.restore_cost(&(DMatrix::identity(n, n) * weight));
        Self {
            h: &self.h + extra,
            ..self.clone()
        }
    }
}

/// Whether no column of `m` has moved. Column by column, because a small subsystem may still move when a large one has
/// settled.
fn columns_agree(m: &DMatrix<f64>, previous: &DMatrix<f64>) -> bool {
    (m - previous)
        .column_iter()
        .zip(m.column_iter())
        .all(|(change, column)| change.norm() <= SETTLED * column.norm())
}

/// The symmetric part.
pub(super) fn symmetrized(m: DMatrix<f64>) -> DMatrix<f64> {
    let transposed = m.transpose();
    (m + transposed) * 0.5
}

/// Whether every entry is a number.
pub(super) fn is_finite(m: &DMatrix<f64>) -> bool {
    m.iter().all(|entry| entry.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::ROUNDING;
    use approx::assert_relative_eq;

    fn scalar(a: f64, g: f64, h: f64) -> Triple {
        let [a, g, h] = [a, g, h].map(|x| DMatrix::from_element(1, 1, x));
        Triple { a, g, h }
    }

    fn example() -> Triple {
        Triple {
            a: DMatrix::from_row_slice(2, 2, &[1.1, 0.3, -0.2, 0.7]),
            g: DMatrix::from_row_slice(2, 2, &[0.5, 0.1, 0.1, 0.4]),
            h: DMatrix::from_row_slice(2, 2, &[1.0, 0.2, 0.2, 0.3]),
        }
    }

    /// P ← H + Aᵀ P (I + G P)⁻¹ A.
    fn value_iteration(t: &Triple, steps: usize) -> DMatrix<f64> {
        (0..steps).fold(DMatrix::zeros(2, 2), |p, _| {
            let w = DMatrix::identity(2, 2) + &t.g * &p;
            &t.h + t.a.transpose() * &p * w.try_inverse().unwrap() * &t.a
        })
    }

    #[test]
    fn three_doublings_equal_eight_value_iterations() {
        let mut triple = example();
        for _ in 0..3 {
            triple = triple.doubled().unwrap();
        }
        assert_relative_eq!(triple.h, value_iteration(&example(), 8), epsilon = 1e-13);
    }

    // P = h / (1 − a²) and P = −h / (2 a).
    #[test]
    fn scalar_lyapunov_equals_closed_form() {
        let one = |x| DMatrix::from_element(1, 1, x);
        let discrete = solve_lyapunov(TimeDomain::Discrete, one(0.9), one(2.0));
        let continuous = solve_lyapunov(TimeDomain::Continuous, one(-0.3), one(2.0));
        assert_relative_eq!(
            discrete[0],
            2.0 / (1.0 - 0.81),
            max_relative = 10.0 * ROUNDING
        );
        assert_relative_eq!(continuous[0], 2.0 / 0.6, max_relative = 10.0 * ROUNDING);
    }

    #[test]
    fn cayley_transform_keeps_the_solution_for_every_scalar() {
        // P = (a + √(a² + g h)) / g solves 2 a P − g P² + h = 0.
        for (a, g, h) in [
            (1.0, 1.0, 1.0),
            (-3.0, 0.1, 5.0),
            (0.0, 2.0, 7.0),
            (4.0, 1e-3, 1e3),
        ] {
            let expected = (a + f64::hypot(a, f64::sqrt(g * h))) / g;
            let found = solve(TimeDomain::Continuous, &scalar(a, g, h)).cost[0];
            assert_relative_eq!(found, expected, max_relative = 1e-13);
        }
    }

    #[test]
    fn lyapunov_residual_vanishes_for_an_indefinite_right_side() {
        let a = DMatrix::from_row_slice(2, 2, &[0.5, 1.0, -0.2, 0.3]);
        let h = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, 1.0, 0.0]);
        let p = solve_lyapunov(TimeDomain::Discrete, a.clone(), h.clone());
        assert_relative_eq!(a.transpose() * &p * &a + h, p, epsilon = 10.0 * ROUNDING);
    }

    #[test]
    fn regularization_weighs_the_state_that_the_cost_ignores() {
        let triple = scalar(2.0, 1.0, 0.0);
        assert_eq!(solve(TimeDomain::Discrete, &triple).cost[0], 0.0);
        let p = solve(TimeDomain::Discrete, &triple.regularized(1e-3)).cost[0];
        assert!((p - 3.0).abs() < 0.05, "P = (a² − 1) / g = 3, found {p}");
    }
}
