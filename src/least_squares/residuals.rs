//! Residuals and their Jacobians.

use nalgebra::DMatrix;

use crate::autodiff::{CHUNK, JacobianScratch, VectorFunction, jacobian_into};

/// Residuals r(x) ∈ ℝᵐ to be minimised. The implementor may own working memory.
pub trait Residuals {
    /// Number of residuals m.
    fn n_residuals(&self) -> usize;

    /// Computes the residuals.
    ///
    /// * `out` – output, length m; what is not finite is taken for a point that cannot be
    fn residuals(&mut self, x: &[f64], out: &mut [f64]);

    /// Computes the Jacobian ∂r/∂x in the directions in which [`retract`](Self::retract) moves.
    ///
    /// * `out` – output, m × [`n_directions`](Self::n_directions)
    fn jacobian(&mut self, x: &[f64], out: &mut DMatrix<f64>);

    /// Number of directions in which the variables can move: as many as there are variables, unless these are points of a curved space.
    fn n_directions(&self, x: &[f64]) -> usize {
        x.len()
    }

    /// Computes x ⊕ d, the variables after a step; x + d unless they are points of a curved space, such as quaternions, with a
    /// [`retract`](Self::retract) of its own.
    ///
    /// * `d` – step, as many as there are directions
    /// * `out` – output, as many as `x`
    fn retract(&self, x: &[f64], d: &[f64], out: &mut [f64]) {
        for ((out, x), d) in out.iter_mut().zip(x).zip(d) {
            *out = x + d;
        }
    }
}

/// A function over the scalar as [`Residuals`]: the Jacobian by dual numbers, exact to rounding.
#[derive(Clone, Debug)]
pub struct ByDuals<F> {
    function: F,
    /// Of the number of variables that came last.
    scratch: Option<JacobianScratch<CHUNK>>,
}

impl<F: VectorFunction> ByDuals<F> {
    /// Makes residuals from the outputs of a function.
    pub fn new(function: F) -> Self {
        Self {
            function,
            scratch: None,
        }
    }
}

impl<F: VectorFunction> Residuals for ByDuals<F> {
    fn n_residuals(&self) -> usize {
        self.function.n_outputs()
    }

    fn residuals(&mut self, x: &[f64], out: &mut [f64]) {
        self.function.eval(x, out);
    }

    fn jacobian(&mut self, x: &[f64], out: &mut DMatrix<f64>) {
        let (function, m) = (&self.function, self.function.n_outputs());
        let scratch = (self.scratch).get_or_insert_with(|| JacobianScratch::new(x.len(), m));
        jacobian_into(x, |x, y| function.eval(x, y), scratch, out);
    }
}
