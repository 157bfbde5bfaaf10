//! Derivatives by finite differences: slower and less exact, but independent of dual numbers.

use nalgebra::DMatrix;

use super::VectorFunction;

/// Step, relative to the size of the entry: balances the truncation error h⁴ against the rounding error ε / h.
const RELATIVE_STEP: f64 = 1e-3;

/// The Jacobian at `x`, outputs × inputs, by central differences of fourth order; about eleven digits for smooth functions of
/// size and curvature one.
///
/// The same signature as [`super::jacobian`].
pub fn jacobian<F: VectorFunction>(f: &F, x: &[f64]) -> DMatrix<f64> {
    let m = f.n_outputs();
    let mut out = DMatrix::zeros(m, x.len());
    let mut moved = x.to_vec();
    let mut y = vec![0.0; m];
    for i in 0..x.len() {
        let h = RELATIVE_STEP * x[i].abs().max(1.0);
        // f' ≈ (8 (f(x + h) − f(x − h)) − (f(x + 2h) − f(x − 2h))) / 12 h
        for (offset, weight) in [(h, 8.0), (-h, -8.0), (2.0 * h, -1.0), (-2.0 * h, 1.0)] {
            moved[i] = x[i] + offset;
            f.eval(&moved, &mut y);
            out.column_mut(i)
                .iter_mut()
                .zip(&y)
                .for_each(|(out, y)| *out += y * weight / (12.0 * h));
        }
        moved[i] = x[i];
    }
    out
}
