//! Predicted reduction of a policy: the change of the cost to second order.

use super::product::dot;
use super::stage::Stage;

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

/// Follows the policy through the linear dynamics from `first`; what bends the dynamics counts with the curvature of the cost.
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
