//! Predicted reduction of a policy: the change of the cost to second order.

use super::stage::Stage;
use crate::linalg::product::dot;

/// Predicted change of the cost along the direction, by the model that the policy minimises: α g + ½ α² h for a step α.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PredictedChange {
    pub(super) slope: f64,
    pub(super) curvature: f64,
}

impl PredictedChange {
    /// The change with a step α; negative is better.
    pub(super) fn change(self, alpha: f64) -> f64 {
        alpha * (self.slope + 0.5 * alpha * self.curvature)
    }
}

/// Applies the policy to the linear dynamics from `first`; the curvature of the dynamics is included in that of the cost.
///
/// * `dz`, `next` – working memory, length `ndx` + `nu` and `ndx`
pub(super) fn predict_change(
    stages: &[Stage],
    first: &[f64],
    dz: &mut [f64],
    next: &mut [f64],
) -> PredictedChange {
    let n = first.len();
    let mut out = PredictedChange::default();
    dz[..n].copy_from_slice(first);
    for (k, stage) in stages.iter().enumerate() {
        let (dx, du) = dz.split_at_mut(n);
        for (i, (du, feedforward)) in du.iter_mut().zip(&stage.feedforward).enumerate() {
            *du = -feedforward - dot(&stage.gain_t[i * n..][..n], dx);
        }
        let nz = stage.expansion.gradient.len();
        let dz_here = &dz[..nz];
        out.slope += dot(stage.expansion.gradient.as_slice(), dz_here);
        out.curvature += quadratic_form(stage.expansion.hessian.as_slice(), dz_here);
        out.curvature += quadratic_form(&stage.dynamics_hessian, dz_here);
        if k + 1 < stages.len() {
            let images = stage.jacobian_t.chunks_exact(nz.max(1)).zip(&stage.gap);
            for (next, (column, gap)) in next.iter_mut().zip(images) {
                *next = dot(column, dz_here) + gap;
            }
            dz[..n].copy_from_slice(next);
        }
    }
    out
}

/// zᵀ H z from the upper triangle of H, by columns; zero where H is empty.
fn quadratic_form(h: &[f64], z: &[f64]) -> f64 {
    let mut sum = 0.0;
    for (j, column) in h.chunks_exact(z.len().max(1)).enumerate() {
        let above = dot(&column[..j], &z[..j]);
        sum += z[j] * (2.0 * above + column[j] * z[j]);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Scalar;
    use crate::trajopt::ddp::Ddp;
    use crate::trajopt::{
        Activation, Cost, InputError, Problem, Scratch, StateError, System, Trajectory,
    };

    /// x⁺ = x + u.
    struct Counter;
    impl System for Counter {
        fn nx(&self) -> usize {
            1
        }
        fn nu(&self) -> usize {
            1
        }
        fn step<T: Scalar>(&self, x: &[T], u: &[T], _: &mut Scratch, next: &mut [T]) {
            next[0] = x[0] + u[0];
        }
    }

    // min ½ u² + ½ (x + u)² from u = 0: the policy u = −x/2 changes the cost by −½ x² α + ¼ x² α², exactly.
    #[test]
    fn predicted_change_of_a_linear_quadratic_problem_is_the_actual_one() {
        let cost = Cost::new().with(1.0, Activation::Quadratic, InputError::to(&[0.0]));
        let last = Cost::new().with(1.0, Activation::Quadratic, StateError::to(&[0.0]));
        let problem = Problem::new(Counter, 1, &[3.0])
            .with_stage_cost(cost)
            .with_final_cost(last);
        let mut reports = Vec::new();
        let guess = Trajectory::rollout(&problem, &Trajectory::zero_input(&problem).inputs);
        let mut ddp = Ddp::new(&problem);
        let solution = ddp.solve_with(&problem, &guess, |at| reports.push(*at));
        let predicted = reports[0].predicted_reduction.expect("Ddp predicts");
        assert!((predicted - 9.0 / 4.0).abs() < 1e-7, "{predicted}");
        assert!((solution.cost_history[0] - solution.cost - predicted).abs() < 1e-7);
    }

    #[test]
    fn quadratic_form_reads_the_upper_triangle_alone() {
        // [1 2; 2 3] by columns
        let h = [1.0, f64::NAN, 2.0, 3.0];
        assert_eq!(quadratic_form(&h, &[5.0, -1.0]), 25.0 - 20.0 + 3.0);
        assert_eq!(quadratic_form(&[], &[5.0, -1.0]), 0.0);
    }
}
