//! The Riccati equation of a linear-quadratic regulator: its gain, its residual and its Newton correction.
//!
//! The input is scaled so that its weight is the identity (û = Lᵀ u with R = L Lᵀ, hence B̂ = B L⁻ᵀ). For a gain K and
//! the loop it closes, Ā = A − B K, both forms of the equation read: the cost of running that loop is P,
//!
//! ```text
//!   discrete      Āᵀ P Ā − P     + Q + KᵀK = 0    with K = (I + BᵀPB)⁻¹ BᵀPA    (1)
//!   continuous    Āᵀ P + P Ā     + Q + KᵀK = 0    with K = BᵀP                  (2)
//! ```
//!
//! In this form an error of the gain enters the residual only to second order.

use nalgebra::{Cholesky, DMatrix, Dyn};

use super::balance::Balance;
use super::doubling::{self, Doubled, TimeDomain, symmetrized};
use super::triple::Triple;
use crate::scalar::MapEach;

/// Relative change of the cost at which Newton's method has settled: the step after it would change only rounding
/// errors.
const NEWTON_SETTLED: f64 = 1e-8;

/// A Riccati equation whose input weight is the identity.
#[derive(Clone, Debug)]
pub(super) struct Riccati {
    pub(super) time: TimeDomain,
    pub(super) a: DMatrix<f64>,
    pub(super) b: DMatrix<f64>,
    pub(super) q: DMatrix<f64>,
}

impl Riccati {
    /// The equation for the weights `q` and R = L Lᵀ.
    pub(super) fn new(
        time: TimeDomain,
        [a, b, q]: [&DMatrix<f64>; 3],
        r: &Cholesky<f64, Dyn>,
    ) -> Self {
        // B̂ᵀ = L⁻¹ Bᵀ
        let mut bt = b.transpose();
        r.l_dirty().solve_lower_triangular_mut(&mut bt);
        Self {
            time,
            a: a.clone(),
            b: bt.transpose(),
            q: symmetrized(q.clone()),
        }
    }

    /// Equation for the balanced state x̂.
    pub(super) fn balanced(&self, balance: &Balance) -> Self {
        Self {
            time: self.time,
            a: balance.state_map(&self.a),
            b: balance.input(&self.b),
            q: balance.cost(&self.q),
        }
    }

    /// The data A, G = B Bᵀ and H = Q of the doubling algorithm.
    pub(super) fn triple(&self) -> Triple {
        Triple {
            a: self.a.clone(),
            g: &self.b * self.b.transpose(),
            h: self.q.clone(),
        }
    }

    /// The cost of the regulator, if the cost sees every mode that is not stable.
    pub(super) fn solve(&self) -> Doubled {
        doubling::solve(self.time, &self.triple())
    }

    /// The cost of a nearby regulator, which sees every mode because every state is weighed with this `strength`.
    pub(super) fn solve_regularized(&self, strength: f64) -> Doubled {
        doubling::solve(self.time, &self.triple().regularized(strength))
    }

    /// The gain that is optimal for the cost P; zero where I + Bᵀ P B is not positive definite.
    pub(super) fn gain(&self, p: &DMatrix<f64>) -> DMatrix<f64> {
        let btp = self.b.tr_mul(p);
        match self.time {
            TimeDomain::Continuous => btp,
            TimeDomain::Discrete => {
                let nu = self.b.ncols();
                let curvature = DMatrix::identity(nu, nu) + symmetrized(&btp * &self.b);
                let btpa = btp * &self.a;
                Cholesky::new(curvature)
                    .map_or_else(|| DMatrix::zeros(nu, self.a.nrows()), |c| c.solve(&btpa))
            }
        }
    }

    /// A − B K.
    pub(super) fn closed_loop(&self, gain: &DMatrix<f64>) -> DMatrix<f64> {
        &self.a - &self.b * gain
    }

    /// The left side of (1) or (2), symmetric, and the sum of the norms of its terms.
    fn defect(&self, p: &DMatrix<f64>) -> (DMatrix<f64>, f64) {
        let k = self.gain(p);
        let ak = self.closed_loop(&k);
        let ktk = k.tr_mul(&k);
        let (first, second) = match self.time {
            TimeDomain::Discrete => (ak.tr_mul(&(p * &ak)), -p),
            TimeDomain::Continuous => (ak.tr_mul(p), p * &ak),
        };
        let size = [&first, &second, &self.q, &ktk].map_each(DMatrix::norm);
        let defect = first + second + &self.q + ktk;
        (symmetrized(defect), size.iter().sum())
    }

    /// The norm of the left side over the sum of the norms of its terms; zero where all terms are.
    pub(super) fn relative_residual(&self, p: &DMatrix<f64>) -> f64 {
        let (defect, size) = self.defect(p);
        if size == 0.0 {
            0.0
        } else {
            defect.norm() / size
        }
    }

    /// One Newton step: the cost P + ΔP of running the gain of P, where ΔP solves the Lyapunov equation of that loop
    /// with the residual on its right side. P must stabilise.
    pub(super) fn newton_step(&self, p: &DMatrix<f64>) -> DMatrix<f64> {
        let ak = self.closed_loop(&self.gain(p));
        let (defect, _) = self.defect(p);
        p + doubling::solve_lyapunov(self.time, ak, defect)
    }

    /// Newton steps until the cost has settled, at most `limit`; the cost and the steps made.
    ///
    /// From a stabilising start they descend to the stabilising solution, quadratically in the end
    /// [Kleinman 1968; Hewer 1971, the discrete equation].
    pub(super) fn descend(&self, start: DMatrix<f64>, limit: usize) -> (DMatrix<f64>, usize) {
        let mut p = start;
        for step in 0..limit {
            let next = self.newton_step(&p);
            let change = (&next - &p).norm();
            // In exact arithmetic no step raises the cost.
            let descends = next.norm() <= 2.0 * p.norm();
            if !descends {
                return (p, step);
            }
            p = next;
            if change <= NEWTON_SETTLED * p.norm() {
                return (p, step + 1);
            }
        }
        (p, limit)
    }

    /// Newton steps for as long as each at least halves the residual, at most `limit`; the cost and the steps kept.
    pub(super) fn polish(&self, start: DMatrix<f64>, limit: usize) -> (DMatrix<f64>, usize) {
        let mut p = start;
        let mut residual = self.relative_residual(&p);
        for step in 0..limit {
            let next = self.newton_step(&p);
            let next_residual = self.relative_residual(&next);
            // False for a residual that is NaN, too.
            let halved = next_residual < 0.5 * residual;
            if !halved {
                return (p, step);
            }
            (p, residual) = (next, next_residual);
        }
        (p, limit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{ROUNDING, SAME_ALGEBRA};
    use approx::assert_relative_eq;

    fn oscillator(time: TimeDomain) -> Riccati {
        Riccati {
            time,
            a: DMatrix::from_row_slice(2, 2, &[0.9, 0.2, -0.2, 0.9]),
            b: DMatrix::from_row_slice(2, 1, &[0.0, 1.0]),
            q: DMatrix::identity(2, 2),
        }
    }

    #[test]
    fn residual_equals_the_textbook_form() {
        let p = DMatrix::from_row_slice(2, 2, &[2.0, 0.3, 0.3, 1.0]);
        // AᵀPA − P − AᵀPB (1 + BᵀPB)⁻¹ BᵀPA + Q
        let r = oscillator(TimeDomain::Discrete);
        let pab = r.a.tr_mul(&p) * &r.b;
        let curvature = 1.0 + (r.b.tr_mul(&p) * &r.b)[0];
        let expected = r.a.tr_mul(&p) * &r.a - &p - &pab * pab.transpose() / curvature + &r.q;
        assert_relative_eq!(r.defect(&p).0, expected, epsilon = 10.0 * ROUNDING);
        // AᵀP + PA − PBBᵀP + Q
        let r = oscillator(TimeDomain::Continuous);
        let pb = &p * &r.b;
        let expected = r.a.tr_mul(&p) + &p * &r.a - &pb * pb.transpose() + &r.q;
        assert_relative_eq!(r.defect(&p).0, expected, epsilon = 10.0 * ROUNDING);
    }

    #[test]
    fn newton_from_a_distant_stabilising_cost_reaches_the_doubling_solution() {
        for time in [TimeDomain::Discrete, TimeDomain::Continuous] {
            let riccati = oscillator(time);
            let expected = riccati.solve().cost;
            let (p, steps) = riccati.descend(&expected * 3.0, 20);
            assert!(steps < 10, "{time:?}: {steps} steps");
            assert_relative_eq!(p, expected, max_relative = SAME_ALGEBRA);
        }
    }

    #[test]
    fn polishing_never_raises_the_residual() {
        let riccati = oscillator(TimeDomain::Discrete);
        let start = riccati.solve().cost * 1.01;
        let before = riccati.relative_residual(&start);
        let (refined, steps) = riccati.polish(start, 10);
        assert!(riccati.relative_residual(&refined) < 1e-6 * before);
        assert!((1..10).contains(&steps));
    }
}
