//! Derivatives by finite differences: slower and less exact, but independent of dual numbers.

use nalgebra::DMatrix;

use super::VectorFunction;

/// Largest step, relative to the size of the entry. The extrapolation finds its way down from there.
const FIRST_STEP: f64 = 1.0 / 32.0;

/// How often the step is halved: down to 3e-5, where rounding has taken over.
const LEVELS: usize = 10;

/// The Jacobian at `x`, outputs × inputs, by central differences extrapolated to step zero.
///
/// The same signature as [`super::jacobian`]. Each entry keeps the extrapolation with the least estimated error: about eleven
/// digits for smooth functions, at 20 evaluations an input. Allocates.
///
/// # References
/// [Ridders 1982].
pub fn jacobian<F: VectorFunction>(f: &F, x: &[f64]) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(f.n_outputs(), x.len());
    for i in 0..x.len() {
        let levels = central_differences(f, x, i);
        for (row, out) in out.column_mut(i).iter_mut().enumerate() {
            *out = extrapolate(std::array::from_fn(|level| levels[level][row]));
        }
    }
    out
}

/// (f(x + h eᵢ) − f(x − h eᵢ)) / 2h for h halved from level to level.
fn central_differences<F: VectorFunction>(f: &F, x: &[f64], i: usize) -> [Vec<f64>; LEVELS] {
    let mut h = 2.0 * FIRST_STEP * x[i].abs().max(1.0);
    let mut moved = x.to_vec();
    let mut evaluate = |x_i: f64| {
        let mut y = vec![0.0; f.n_outputs()];
        moved[i] = x_i;
        f.eval(&moved, &mut y);
        y
    };
    std::array::from_fn(|_| {
        h *= 0.5;
        let (plus, minus) = (evaluate(x[i] + h), evaluate(x[i] - h));
        plus.iter()
            .zip(&minus)
            .map(|(plus, minus)| (plus - minus) / (2.0 * h))
            .collect()
    })
}

/// Neville's tableau in h²; the answer is the entry that differs least from the two it was made of.
fn extrapolate(mut column: [f64; LEVELS]) -> f64 {
    let mut best = (f64::INFINITY, column[0]);
    let mut factor = 1.0;
    for order in 1..LEVELS {
        factor *= 4.0;
        for level in (order..LEVELS).rev() {
            let (coarse, fine) = (column[level - 1], column[level]);
            let value = fine + (fine - coarse) / (factor - 1.0);
            let error = (value - fine).abs().max((value - coarse).abs());
            if error <= best.0 {
                best = (error, value);
            }
            column[level] = value;
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Scalar;

    /// (sin ωx, 1 / (x + 1/ω²)) with very different curvatures.
    struct Wiggle;
    impl VectorFunction for Wiggle {
        fn n_outputs(&self) -> usize {
            2
        }
        fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
            y[0] = (x[0] * 20.0).sin_cos().0;
            y[1] = T::one() / (x[0] + 0.05);
        }
    }

    #[test]
    fn extrapolated_differences_equal_closed_form_despite_large_curvature() {
        let j = jacobian(&Wiggle, &[0.1]);
        assert!((j[0] - 20.0 * 2.0_f64.cos()).abs() < 1e-9, "{j}");
        assert!((j[1] + 1.0 / (0.15 * 0.15)).abs() < 1e-8, "{j}");
    }
}
