//! The finite-horizon, time-varying linear-quadratic regulator.
//!
//! For xₖ₊₁ = Aₖ xₖ + Bₖ uₖ the cost  xₙᵀ Pₙ xₙ + Σₖ xₖᵀ Qₖ xₖ + uₖᵀ Rₖ uₖ  is minimised by uₖ = −Kₖ xₖ. The gains
//! follow from the end to the start:
//!
//! ```text
//!   Kₖ = (Rₖ + Bₖᵀ Pₖ₊₁ Bₖ)⁻¹ Bₖᵀ Pₖ₊₁ Aₖ                                  (1)
//!   Pₖ = Qₖ + Kₖᵀ Rₖ Kₖ + (Aₖ − Bₖ Kₖ)ᵀ Pₖ₊₁ (Aₖ − Bₖ Kₖ)               (2)
//! ```
//!
//! (2) is the cost of running the gain, Joseph's form: an error of the gain enters it only to second order, and Pₖ
//! stays positive semidefinite if the weights are.

use std::fmt;

use nalgebra::{Cholesky, DMatrix, DVector};

use super::doubling::{is_finite, symmetrized};

/// Stage of a finite-horizon problem: x⁺ = A x + B u at the cost xᵀ Q x + uᵀ R u.
#[derive(Clone, Debug, PartialEq)]
pub struct LqrStage {
    /// A, from the states of this stage to those of the next, nx⁺ × nx.
    pub a: DMatrix<f64>,
    /// B, nx⁺ × nu.
    pub b: DMatrix<f64>,
    /// Weight on the state, nx × nx. Only its symmetric part matters; it may be indefinite.
    pub q: DMatrix<f64>,
    /// Weight on the input, nu × nu. Only its symmetric part matters; it may be singular if R + Bᵀ P B is not.
    pub r: DMatrix<f64>,
}

/// The gains and costs of a finite-horizon regulator.
///
/// Made by [`FiniteHorizonLqr::discrete`]. Check [`status`](Self::status).
#[derive(Clone, Debug, PartialEq)]
pub struct FiniteHorizonLqr {
    /// Kₖ of uₖ = −Kₖ xₖ for each stage, nu × nx. Zero for stages that were not reached.
    pub gains: Vec<DMatrix<f64>>,
    /// Pₖ of the cost xₖᵀ Pₖ xₖ that remains from stage k, symmetric, nx × nx: one more than stages; the last is the final cost. Zero for stages that
    /// were not reached.
    pub costs_to_go: Vec<DMatrix<f64>>,
    /// Status: all stages solved, or the first stage that failed.
    pub status: FiniteHorizonStatus,
}

/// Termination status of the backward pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FiniteHorizonStatus {
    /// All stages have their gains.
    Solved,
    /// R + Bᵀ P B is not positive definite: the cost has no minimum, or no unique one, over the input of this stage.
    NotConvex {
        /// The stage, counted from zero at the start of the horizon.
        stage: usize,
    },
    /// An entry of this stage (for the number of stages: of the final cost) is infinite or NaN, or the cost
    /// overflows.
    NotFinite {
        /// The stage, counted from zero at the start of the horizon.
        stage: usize,
    },
}

impl FiniteHorizonLqr {
    /// Designs the regulator that minimises  xₙᵀ Pₙ xₙ + Σₖ xₖᵀ Qₖ xₖ + uₖᵀ Rₖ uₖ  subject to xₖ₊₁ = Aₖ xₖ + Bₖ uₖ.
    ///
    /// One backward pass of O(nx³) per stage; allocates its results.
    ///
    /// * `stages` – dynamics and weights of the stages 0 … n − 1; the number of states may change from stage to stage
    /// * `final_cost` – Pₙ, for the states after the last stage; only its symmetric part matters
    ///
    /// The pass stops at the first stage (from the end) that has no minimum; the stages after it keep their gains.
    ///
    /// # Panics
    /// If the shapes of a stage do not fit together or to the next stage.
    ///
    /// # Examples
    /// ```
    /// use dualbody::control::{FiniteHorizonLqr, LqrStage};
    /// use nalgebra::dmatrix;
    ///
    /// // One step of x⁺ = x + u with unit weights: minimise u² + (x + u)², so u = −x / 2.
    /// let one = dmatrix![1.0];
    /// let stage = LqrStage { a: one.clone(), b: one.clone(), q: one.clone(), r: one.clone() };
    /// assert!((FiniteHorizonLqr::discrete(&[stage], &one).gains[0][0] - 0.5).abs() < 1e-12);
    /// ```
    ///
    /// # References
    /// [Anderson and Moore 1990; Bucy and Joseph 1968].
    pub fn discrete(stages: &[LqrStage], final_cost: &DMatrix<f64>) -> Self {
        assert_shapes(stages, final_cost);
        let mut solution = Self::unsolved(stages, final_cost);
        solution.status = solution.backward_pass(stages);
        solution
    }

    /// The input uₖ = −Kₖ xₖ.
    ///
    /// * `stage` – k, from 0 to n − 1
    /// * `x` – state at that stage, length nx
    ///
    /// # Panics
    /// If there is no such stage, or if `x` has the wrong length.
    pub fn control(&self, stage: usize, x: &DVector<f64>) -> DVector<f64> {
        let n = self.gains.len();
        assert!(
            stage < n,
            "there is no stage {stage}: the horizon has {n}, counted from 0"
        );
        let nx = self.gains[stage].ncols();
        assert!(x.len() == nx, "the state has length {}, not {nx}", x.len());
        -(&self.gains[stage] * x)
    }

    /// Whether every stage has its gain.
    pub fn is_solved(&self) -> bool {
        self.status == FiniteHorizonStatus::Solved
    }

    fn unsolved(stages: &[LqrStage], final_cost: &DMatrix<f64>) -> Self {
        let gain = |stage: &LqrStage| DMatrix::zeros(stage.b.ncols(), stage.a.ncols());
        let cost = |stage: &LqrStage| DMatrix::zeros(stage.a.ncols(), stage.a.ncols());
        let last = symmetrized(final_cost.clone());
        Self {
            gains: stages.iter().map(gain).collect(),
            costs_to_go: stages.iter().map(cost).chain([last]).collect(),
            status: FiniteHorizonStatus::Solved,
        }
    }

    fn backward_pass(&mut self, stages: &[LqrStage]) -> FiniteHorizonStatus {
        let n = stages.len();
        if !is_finite(&self.costs_to_go[n]) {
            return FiniteHorizonStatus::NotFinite { stage: n };
        }
        for (k, stage) in stages.iter().enumerate().rev() {
            if !stage.is_finite() {
                return FiniteHorizonStatus::NotFinite { stage: k };
            }
            let next_cost = &self.costs_to_go[k + 1];
            let Some(gain) = stage.gain(next_cost) else {
                return FiniteHorizonStatus::NotConvex { stage: k };
            };
            let cost = stage.cost(&gain, next_cost);
            if !is_finite(&cost) {
                return FiniteHorizonStatus::NotFinite { stage: k };
            }
            (self.gains[k], self.costs_to_go[k]) = (gain, cost);
        }
        FiniteHorizonStatus::Solved
    }
}

impl LqrStage {
    /// Equation (1), or `None` if R + Bᵀ P B is not positive definite.
    fn gain(&self, next_cost: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let btp = self.b.tr_mul(next_cost);
        let curvature = symmetrized(&self.r + &btp * &self.b);
        Some(Cholesky::new(curvature)?.solve(&(btp * &self.a)))
    }

    /// Equation (2).
    fn cost(&self, gain: &DMatrix<f64>, next_cost: &DMatrix<f64>) -> DMatrix<f64> {
        let closed_loop = &self.a - &self.b * gain;
        let input_cost = gain.tr_mul(&(&self.r * gain));
        symmetrized(&self.q + input_cost + closed_loop.tr_mul(&(next_cost * &closed_loop)))
    }

    fn is_finite(&self) -> bool {
        [&self.a, &self.b, &self.q, &self.r]
            .into_iter()
            .all(is_finite)
    }
}

fn assert_shapes(stages: &[LqrStage], final_cost: &DMatrix<f64>) {
    let nexts = stages.iter().skip(1).map(|stage| stage.a.ncols());
    for (k, (stage, next)) in stages
        .iter()
        .zip(nexts.chain([final_cost.nrows()]))
        .enumerate()
    {
        let (nx, nu) = (stage.a.ncols(), stage.b.ncols());
        assert!(
            stage.a.nrows() == next,
            "stage {k}: A does not have {next} rows"
        );
        assert!(
            stage.b.nrows() == next,
            "stage {k}: B does not have {next} rows"
        );
        assert!(
            stage.q.shape() == (nx, nx),
            "stage {k}: Q is not {nx} x {nx}"
        );
        assert!(
            stage.r.shape() == (nu, nu),
            "stage {k}: R is not {nu} x {nu}"
        );
    }
    assert!(final_cost.is_square(), "the final cost is not square");
}

impl fmt::Display for FiniteHorizonStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Solved => write!(f, "solved"),
            Self::NotConvex { stage } => {
                write!(
                    f,
                    "not convex: R + BᵀPB of stage {stage} is not positive definite"
                )
            }
            Self::NotFinite { stage } => {
                write!(
                    f,
                    "stage {stage} has or leads to a number that is not finite"
                )
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Lqr;
    use super::*;
    use crate::tests::{ROUNDING, SAME_ALGEBRA};
    use approx::assert_relative_eq;
    use nalgebra::dmatrix;

    /// Distinct dynamics and weights at every stage; three states, two inputs.
    fn varying_stage(k: usize) -> LqrStage {
        let t = k as f64;
        LqrStage {
            a: dmatrix![
                1.1, 0.3 * t.sin(), 0.0;
                -0.2, 0.9, 0.1 * t;
                0.0, 0.4, 1.05
            ],
            b: dmatrix![0.0, 0.2; 1.0, 0.1 * t; 0.3, 1.0],
            q: DMatrix::identity(3, 3) * (1.0 + 0.1 * t),
            r: dmatrix![0.5, 0.1; 0.1, 0.3 + 0.05 * t],
        }
    }

    fn scalar_stage(a: f64, b: f64, q: f64, r: f64) -> LqrStage {
        let [a, b, q, r] = [a, b, q, r].map(|x| dmatrix![x]);
        LqrStage { a, b, q, r }
    }

    /// The inputs of all stages, one above the other, that minimise the cost as one quadratic in them.
    ///
    /// xₖ = Fₖ x₀ + Gₖ U for the stacked inputs U, so (R̄ + Σ Gₖᵀ Qₖ Gₖ) U = −Σ Gₖᵀ Qₖ Fₖ x₀.
    fn stacked_minimizer(
        stages: &[LqrStage],
        last: &DMatrix<f64>,
        x0: &DVector<f64>,
    ) -> DVector<f64> {
        let (nx, nu, n) = (x0.len(), stages[0].b.ncols(), stages.len());
        let (mut f, mut g) = (DMatrix::identity(nx, nx), DMatrix::zeros(nx, nu * n));
        let (mut h, mut c) = (DMatrix::zeros(nu * n, nu * n), DMatrix::zeros(nu * n, nx));
        for (k, stage) in stages.iter().enumerate() {
            h += g.tr_mul(&(&stage.q * &g));
            c += g.tr_mul(&(&stage.q * &f));
            let mut block = h.view_mut((k * nu, k * nu), (nu, nu));
            block += &stage.r;
            (f, g) = (&stage.a * f, &stage.a * g);
            let mut block = g.view_mut((0, k * nu), (nx, nu));
            block += &stage.b;
        }
        h += g.tr_mul(&(last * &g));
        c += g.tr_mul(&(last * &f));
        h.lu().solve(&(-c * x0)).unwrap()
    }

    #[test]
    fn inputs_equal_those_of_the_stacked_least_squares_problem() {
        let stages: Vec<_> = (0..7).map(varying_stage).collect();
        let last = dmatrix![2.0, 0.1, 0.0; 0.1, 1.0, 0.0; 0.0, 0.0, 3.0];
        let solution = FiniteHorizonLqr::discrete(&stages, &last);
        assert!(solution.is_solved());
        let mut x = DVector::from_vec(vec![1.0, -2.0, 0.5]);
        let expected = stacked_minimizer(&stages, &last, &x);
        for (k, stage) in stages.iter().enumerate() {
            let u = solution.control(k, &x);
            assert_relative_eq!(
                u,
                expected.rows(2 * k, 2).into_owned(),
                epsilon = SAME_ALGEBRA
            );
            x = &stage.a * x + &stage.b * u;
        }
    }

    #[test]
    fn cost_to_go_equals_the_simulated_cost_from_every_stage() {
        let stages: Vec<_> = (0..9).map(varying_stage).collect();
        let last = DMatrix::identity(3, 3);
        let solution = FiniteHorizonLqr::discrete(&stages, &last);
        let start = DVector::from_vec(vec![0.3, 1.0, -0.7]);
        for first in 0..stages.len() {
            let (mut x, mut cost) = (start.clone(), 0.0);
            for (k, stage) in stages.iter().enumerate().skip(first) {
                let u = solution.control(k, &x);
                cost += x.dot(&(&stage.q * &x)) + u.dot(&(&stage.r * &u));
                x = &stage.a * x + &stage.b * u;
            }
            cost += x.dot(&(&last * &x));
            let expected = start.dot(&(&solution.costs_to_go[first] * &start));
            assert_relative_eq!(cost, expected, max_relative = 1e-13);
        }
    }

    #[test]
    fn long_horizon_gain_equals_the_infinite_horizon_gain() {
        let stage = varying_stage(3);
        let infinite = Lqr::discrete(&stage.a, &stage.b, &stage.q, &stage.r);
        let solution = FiniteHorizonLqr::discrete(&vec![stage; 200], &DMatrix::zeros(3, 3));
        assert_relative_eq!(solution.gains[0], infinite.gain, epsilon = SAME_ALGEBRA);
        assert_relative_eq!(
            solution.costs_to_go[0],
            infinite.cost_to_go,
            epsilon = SAME_ALGEBRA
        );
    }

    #[test]
    fn infinite_horizon_cost_as_final_cost_gives_the_same_gain_at_every_stage() {
        let stage = varying_stage(1);
        let infinite = Lqr::discrete(&stage.a, &stage.b, &stage.q, &stage.r);
        let solution = FiniteHorizonLqr::discrete(&vec![stage; 5], &infinite.cost_to_go);
        for gain in &solution.gains {
            assert_relative_eq!(*gain, infinite.gain, epsilon = SAME_ALGEBRA);
        }
    }

    // Pₖ = 1 / (n − k + 1) for x⁺ = x + u, no weight on x, unit weight on u and on the last state: the way is cut in
    // equal steps.
    #[test]
    fn scalar_minimum_energy_gains_equal_closed_form() {
        let n = 6;
        let stages = vec![scalar_stage(1.0, 1.0, 0.0, 1.0); n];
        let solution = FiniteHorizonLqr::discrete(&stages, &dmatrix![1.0]);
        for k in 0..n {
            let expected = 1.0 / (n - k + 1) as f64;
            assert_relative_eq!(
                solution.gains[k][0],
                expected,
                max_relative = 10.0 * ROUNDING
            );
            assert_relative_eq!(
                solution.costs_to_go[k][0],
                expected,
                max_relative = 10.0 * ROUNDING
            );
        }
    }

    // Without input weight one step removes all: K = A / B, the dead-beat gain.
    #[test]
    fn gain_without_input_weight_equals_the_dead_beat_gain() {
        let stages = [scalar_stage(3.0, 2.0, 1.0, 0.0)];
        let solution = FiniteHorizonLqr::discrete(&stages, &dmatrix![1.0]);
        assert_relative_eq!(solution.gains[0][0], 1.5, max_relative = ROUNDING);
        assert_relative_eq!(solution.costs_to_go[0][0], 1.0, max_relative = ROUNDING);
    }

    #[test]
    fn costs_to_go_are_exactly_symmetric() {
        let stages: Vec<_> = (0..20).map(varying_stage).collect();
        for p in FiniteHorizonLqr::discrete(&stages, &DMatrix::identity(3, 3)).costs_to_go {
            assert_eq!(p, p.transpose());
        }
    }

    #[test]
    fn number_of_states_may_change_between_stages() {
        // Two states are merged into one: x⁺ = x₁ + x₂ + u.
        let merge = LqrStage {
            a: dmatrix![1.0, 1.0],
            b: dmatrix![1.0],
            q: DMatrix::zeros(2, 2),
            r: dmatrix![1.0],
        };
        let solution = FiniteHorizonLqr::discrete(&[merge], &dmatrix![1.0]);
        assert_relative_eq!(solution.gains[0], dmatrix![0.5, 0.5], epsilon = ROUNDING);
    }

    #[test]
    fn stage_without_curvature_is_named_and_later_gains_are_kept() {
        let mut stages = vec![scalar_stage(1.0, 1.0, 1.0, 1.0); 5];
        stages[2] = scalar_stage(1.0, 1.0, 1.0, -10.0);
        let solution = FiniteHorizonLqr::discrete(&stages, &dmatrix![1.0]);
        assert_eq!(solution.status, FiniteHorizonStatus::NotConvex { stage: 2 });
        assert!(!solution.is_solved());
        // P₅ = 1, K₄ = 1/2, P₄ = 3/2, K₃ = 3/5.
        assert_relative_eq!(solution.gains[4][0], 0.5, max_relative = ROUNDING);
        assert_relative_eq!(solution.gains[3][0], 0.6, max_relative = ROUNDING);
        assert_eq!(
            (solution.gains[2][0], solution.costs_to_go[2][0]),
            (0.0, 0.0)
        );
        let text = solution.status.to_string();
        assert!(text.contains("stage 2"), "{text}");
    }

    #[test]
    fn stage_with_not_a_number_is_named() {
        let mut stages = vec![scalar_stage(1.0, 1.0, 1.0, 1.0); 4];
        stages[1].a[0] = f64::NAN;
        let status = |stages: &[LqrStage], last| FiniteHorizonLqr::discrete(stages, &last).status;
        let not_finite = |stage| FiniteHorizonStatus::NotFinite { stage };
        assert_eq!(status(&stages, dmatrix![1.0]), not_finite(1));
        assert_eq!(status(&stages, dmatrix![f64::INFINITY]), not_finite(4));
        let growing = vec![scalar_stage(1e200, 0.0, 1.0, 1.0); 4];
        assert_eq!(status(&growing, dmatrix![1.0]), not_finite(3));
    }

    #[test]
    fn empty_horizon_returns_the_final_cost() {
        let solution = FiniteHorizonLqr::discrete(&[], &dmatrix![2.0]);
        assert!(solution.is_solved() && solution.gains.is_empty());
        assert_eq!(solution.costs_to_go, [dmatrix![2.0]]);
    }

    #[test]
    #[should_panic(expected = "stage 0: A does not have 2 rows")]
    fn stage_that_does_not_lead_to_the_final_state_panics() {
        FiniteHorizonLqr::discrete(
            &[scalar_stage(1.0, 1.0, 1.0, 1.0)],
            &DMatrix::identity(2, 2),
        );
    }
}
