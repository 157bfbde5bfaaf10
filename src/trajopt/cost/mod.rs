//! Costs: weighted activations of residuals, their gradients and Hessians.

#[cfg(feature = "second-order")]
mod exact;
mod terms;

use std::fmt;
use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::activation::Activation;
use super::residual::{AnyResidual, Dependence, Node, Residual, ResidualJacobian};
use super::system::{AnySystem, AsSystem};
pub(super) use terms::Point;

/// A sum of terms  w a(r(x, u)): weight, [`Activation`], [`Residual`].
///
/// # Examples
/// ```
/// use dualbody::{Simulator, model::samples, trajopt::{Activation, Cost, InputError, StateError}};
///
/// let simulator = Simulator::new(samples::cartpole());
/// let cost = Cost::new()
///     .with(1e-2, Activation::Quadratic, StateError::to_neutral(&simulator))
///     .with(1e-4, Activation::Quadratic, InputError::to_zero(&simulator));
/// // ½ (10⁻² · 2² + 10⁻⁴ · 10²)
/// let value = cost.value(&simulator, 0, &[2.0, 0.0, 0.0, 0.0], &[10.0, 0.0]);
/// assert!((value - 0.025).abs() < 1e-15);
/// ```
#[derive(Default)]
pub struct Cost {
    terms: Vec<Term>,
}

struct Term {
    weight: f64,
    activation: Activation,
    residual: Box<dyn AnyResidual>,
    /// The stages at which it counts; all where none are said.
    stages: Option<Range<usize>>,
}

/// A function of (x, u) to second order:  value + gᵀ δz + ½ δzᵀ H δz  with δz = (δx, δu).
#[derive(Clone, Debug, PartialEq)]
pub struct Expansion {
    /// The value.
    pub value: f64,
    /// g, length `ndx` + `nu` (`ndx` at the end of the horizon).
    pub gradient: DVector<f64>,
    /// H, symmetric.
    pub hessian: DMatrix<f64>,
}

impl Expansion {
    /// Makes an expansion of zeros: gradient of length `n`, Hessian n × n.
    pub(crate) fn zeros(n: usize) -> Self {
        Self {
            value: 0.0,
            gradient: DVector::zeros(n),
            hessian: DMatrix::zeros(n, n),
        }
    }

    pub(super) fn clear(&mut self) {
        self.value = 0.0;
        self.gradient.fill(0.0);
        self.hessian.fill(0.0);
    }

    /// Copies the upper triangle of H, which is what the functions of this module write, to the lower.
    pub(super) fn mirror(&mut self) {
        self.hessian.fill_lower_triangle_with_upper_triangle();
    }

    /// Adds `slope` rᵢ′ to g and `curvature` rᵢ′ rᵢ′ᵀ to the upper triangle of H, between the first and the last entry
    /// of rᵢ′ that is not zero.
    pub(super) fn add_row(&mut self, row: &[f64], slope: f64, curvature: f64) {
        let n = self.gradient.len();
        let Some(first) = row[..n].iter().position(|&x| x != 0.0) else {
            return;
        };
        let end = row[..n]
            .iter()
            .rposition(|&x| x != 0.0)
            .map_or(n, |i| i + 1);
        let gradient = &mut self.gradient.as_mut_slice()[first..end];
        let both = gradient.iter_mut().zip(&row[first..end]);
        both.for_each(|(g, &x)| *g += slope * x);
        if curvature == 0.0 {
            return;
        }
        let columns = self.hessian.as_mut_slice().chunks_exact_mut(n);
        for (j, column) in columns.enumerate().take(end).skip(first) {
            let scale = curvature * row[j];
            let entries = column[first..=j].iter_mut().zip(&row[first..=j]);
            entries.for_each(|(h, &x)| *h += scale * x);
        }
    }
}

impl Cost {
    /// Makes a cost without terms, which is zero.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a term weight · activation(residual) to all stages.
    ///
    /// # Panics
    /// If the weight is not finite.
    #[must_use]
    pub fn with<R: Residual>(self, weight: f64, activation: Activation, residual: R) -> Self {
        self.with_term(weight, activation, residual.boxed(), None)
    }

    /// [`with`](Self::with) for a term at these stages only.
    ///
    /// # Panics
    /// If the weight is not finite.
    #[must_use]
    pub fn with_during<R: Residual>(
        self,
        stages: Range<usize>,
        weight: f64,
        activation: Activation,
        residual: R,
    ) -> Self {
        self.with_term(weight, activation, residual.boxed(), Some(stages))
    }

    fn with_term(
        mut self,
        weight: f64,
        activation: Activation,
        residual: Box<dyn AnyResidual>,
        stages: Option<Range<usize>>,
    ) -> Self {
        assert!(weight.is_finite(), "a weight of {weight} is not finite");
        self.terms.push(Term {
            weight,
            activation,
            residual,
            stages,
        });
        self
    }

    /// The cost at a stage. Allocates.
    ///
    /// * `x`, `u` – state and input; no input at the end of the horizon
    pub fn value(
        &self,
        dynamics: &(impl AsSystem + ?Sized),
        stage: usize,
        x: &[f64],
        u: &[f64],
    ) -> f64 {
        let at = Point::new(dynamics.as_system(), stage, x, u);
        self.evaluate(at, &mut self.memory(at.system))
    }

    /// Value, gradient and Gauss–Newton Hessian  Σ w r′ᵀ a″ r′  (a″ not below zero), in (δx, δu). Allocates.
    ///
    /// * `x`, `u` – state and input; no input at the end of the horizon
    pub fn expand(
        &self,
        dynamics: &(impl AsSystem + ?Sized),
        stage: usize,
        x: &[f64],
        u: &[f64],
    ) -> Expansion {
        let at = Point::new(dynamics.as_system(), stage, x, u);
        let mut out = Expansion::zeros(at.system.ndx() + u.len());
        self.add_expansion(at, 1.0, &mut self.memory(at.system), &mut out);
        out.mirror();
        out
    }

    fn memory(&self, system: &dyn AnySystem) -> ResidualJacobian {
        ResidualJacobian::new(system, self.largest_dim(system))
    }

    pub(super) fn largest_dim(&self, system: &dyn AnySystem) -> usize {
        let node = Node::new(system, 0);
        let dims = self.terms.iter().map(|term| term.residual.dim(&node));
        dims.max().unwrap_or(0)
    }

    /// Checks that activations fit to residuals, and, at the end of the horizon, that none needs an input.
    pub(super) fn check(&self, system: &dyn AnySystem, is_final: bool) {
        for (k, term) in self.terms.iter().enumerate() {
            let dim = term.residual.dim(&Node::new(system, 0));
            let made_for = term.activation.dim().unwrap_or(dim);
            assert!(
                made_for == dim,
                "term {k}: the residual has {dim} entries, its activation {made_for}"
            );
            assert!(
                !is_final || term.residual.depends_on() != Dependence::Input,
                "term {k} of the final cost is about the input, but the last stage has no input"
            );
        }
    }
}

impl fmt::Debug for Cost {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let terms = self
            .terms
            .iter()
            .map(|term| (term.weight, &term.activation));
        f.debug_list().entries(terms).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // g += s r,  H += c r rᵀ
    #[test]
    fn added_row_equals_the_outer_product_wherever_its_zeros_are() {
        for row in [
            [1.0, 2.0, 3.0],
            [0.0, 2.0, 0.0],
            [0.0, 0.0, -1.0],
            [4.0, 0.0, 5.0],
            [0.0; 3],
        ] {
            let mut out = Expansion::zeros(3);
            out.add_row(&row, 0.5, 2.0);
            out.add_row(&row, 1.5, 0.0);
            out.mirror();
            let r = DVector::from_row_slice(&row);
            assert_eq!(out.gradient, &r * 2.0, "{row:?}");
            assert_eq!(out.hessian, &r * r.transpose() * 2.0, "{row:?}");
        }
    }

    #[test]
    fn cleared_expansion_is_zero() {
        let mut out = Expansion::zeros(2);
        out.value = 1.0;
        out.add_row(&[1.0, -1.0], 1.0, 1.0);
        out.clear();
        assert_eq!(out, Expansion::zeros(2));
    }
}
