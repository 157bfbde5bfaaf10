//! Costs: weighted activations of residuals, their gradients and Hessians.

use std::fmt;
use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use num_dual::HyperDual64;

use super::activation::Activation;
use super::dynamics::Dynamics;
use super::residual::{AnyResidual, Dependence, Node, Residual, ResidualJacobian};
use crate::scalar::{Scalar, lift_into};

/// A sum of terms  w a(r(x, u)): weight, [`Activation`], [`Residual`].
///
/// # Examples
/// ```
/// use dualbody::{Simulator, model::samples, trajopt::{Activation, Cost, InputError, StateError}};
///
/// let simulator = Simulator::new(samples::cartpole());
/// let cost: Cost<Simulator> = Cost::new()
///     .with(1e-2, Activation::Quadratic, StateError::to_neutral(&simulator))
///     .with(1e-4, Activation::Quadratic, InputError::to_zero(&simulator));
/// // ½ (10⁻² · 2² + 10⁻⁴ · 10²)
/// let value = cost.value(&simulator, 0, &[2.0, 0.0, 0.0, 0.0], &[10.0, 0.0]);
/// assert!((value - 0.025).abs() < 1e-15);
/// ```
pub struct Cost<D> {
    terms: Vec<Term<D>>,
}

struct Term<D> {
    weight: f64,
    activation: Activation,
    residual: Box<dyn AnyResidual<D>>,
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
    /// Memory for `n` directions.
    pub fn zeros(n: usize) -> Self {
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

    /// Adds `slope` rᵢ′ to g and `curvature` rᵢ′ rᵢ′ᵀ to the upper triangle of H, between the first and the last entry of rᵢ′ that
    /// is not zero.
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

impl<D: Dynamics> Cost<D> {
    /// No cost.
    pub fn new() -> Self {
        Self { terms: Vec::new() }
    }

    /// Adds  weight · activation(residual).
    ///
    /// # Panics
    /// If the weight is not finite.
    #[must_use]
    pub fn with<R: Residual<D> + 'static>(
        self,
        weight: f64,
        activation: Activation,
        residual: R,
    ) -> Self {
        self.with_term(weight, activation, Box::new(residual), None)
    }

    /// [`with`](Self::with) for a term that counts only at these stages.
    ///
    /// # Panics
    /// If the weight is not finite.
    #[must_use]
    pub fn with_during<R: Residual<D> + 'static>(
        self,
        stages: Range<usize>,
        weight: f64,
        activation: Activation,
        residual: R,
    ) -> Self {
        self.with_term(weight, activation, Box::new(residual), Some(stages))
    }

    fn with_term(
        mut self,
        weight: f64,
        activation: Activation,
        residual: Box<dyn AnyResidual<D>>,
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
    pub fn value(&self, dynamics: &D, stage: usize, x: &[f64], u: &[f64]) -> f64 {
        let mut memory = ResidualJacobian::new(dynamics, self.largest_dim(dynamics));
        self.evaluate(&Node { dynamics, stage }, x, u, &mut memory)
    }

    /// Value, gradient and Gauss–Newton Hessian  Σ w r′ᵀ a″ r′  (a″ not below zero), in (δx, δu). Allocates.
    ///
    /// * `x`, `u` – state and input; no input at the end of the horizon
    pub fn expand(&self, dynamics: &D, stage: usize, x: &[f64], u: &[f64]) -> Expansion {
        let mut memory = ResidualJacobian::new(dynamics, self.largest_dim(dynamics));
        let mut out = Expansion::zeros(dynamics.ndx() + u.len());
        let node = Node { dynamics, stage };
        self.add_expansion(&node, x, u, 1.0, &mut memory, &mut out);
        out.mirror();
        out
    }

    /// Value, gradient and exact Hessian, by hyper-dual numbers. Allocates.
    ///
    /// * `x`, `u` – state and input; no input at the end of the horizon
    pub fn expand_exactly(&self, dynamics: &D, stage: usize, x: &[f64], u: &[f64]) -> Expansion {
        let n = dynamics.ndx() + u.len();
        let mut out = Expansion::zeros(n);
        let node = Node { dynamics, stage };
        let mut seeded = SecondOrder::new(&node, x, u);
        out.value = seeded.cost(self).re;
        for i in 0..n {
            for k in 0..=i {
                let cost = seeded.in_directions(i, k, self);
                out.gradient[i] = cost.eps1;
                out.hessian[(i, k)] = cost.eps1eps2;
                out.hessian[(k, i)] = cost.eps1eps2;
            }
        }
        out
    }

    /// [`value`](Self::value) without allocation.
    pub(super) fn evaluate(
        &self,
        node: &Node<'_, D>,
        x: &[f64],
        u: &[f64],
        memory: &mut ResidualJacobian,
    ) -> f64 {
        let terms = self.terms.iter().filter(|term| term.counts_at(node.stage));
        terms.fold(0.0, |sum, term| {
            memory.values.resize(term.residual.dim(node.dynamics), 0.0);
            term.residual.value(node, x, u, &mut memory.values);
            sum + term.weight * term.activation.value(&memory.values)
        })
    }

    /// Adds `scale` times value, gradient and the upper triangle of the Gauss–Newton Hessian.
    pub(super) fn add_expansion(
        &self,
        node: &Node<'_, D>,
        x: &[f64],
        u: &[f64],
        scale: f64,
        memory: &mut ResidualJacobian,
        out: &mut Expansion,
    ) {
        for term in self.terms.iter().filter(|term| term.counts_at(node.stage)) {
            memory.prepare(term.residual.dim(node.dynamics));
            term.residual.linearize(node, x, u, memory);
            let weight = scale * term.weight;
            out.value += weight * term.activation.value(&memory.values);
            for (i, &r) in memory.values.iter().enumerate() {
                let (slope, curvature) = term.activation.slope_and_curvature(i, r);
                out.add_row(memory.row(i), weight * slope, weight * curvature);
            }
        }
    }

    pub(super) fn largest_dim(&self, dynamics: &D) -> usize {
        let dims = self.terms.iter().map(|term| term.residual.dim(dynamics));
        dims.max().unwrap_or(0)
    }

    /// Checks that activations fit to residuals, and, at the end of the horizon, that none needs an input.
    pub(super) fn check(&self, dynamics: &D, is_final: bool) {
        for (k, term) in self.terms.iter().enumerate() {
            let dim = term.residual.dim(dynamics);
            let made_for = term.activation.dim().unwrap_or(dim);
            assert!(
                made_for == dim,
                "term {k}: the residual has {dim} entries, its activation {made_for}"
            );
            assert!(
                !is_final || term.residual.depends_on() != Dependence::Input,
                "term {k} of the final cost is about the input, which there is none of"
            );
        }
    }
}

impl<D> Term<D> {
    fn counts_at(&self, stage: usize) -> bool {
        let stages = self.stages.as_ref();
        stages.is_none_or(|stages| stages.contains(&stage))
    }
}

impl<D: Dynamics> Default for Cost<D> {
    fn default() -> Self {
        Self::new()
    }
}

impl<D> fmt::Debug for Cost<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let terms = self
            .terms
            .iter()
            .map(|term| (term.weight, &term.activation));
        f.debug_list().entries(terms).finish()
    }
}

/// A point with two directions, on hyper-dual numbers.
struct SecondOrder<'a, D> {
    node: &'a Node<'a, D>,
    base: Vec<HyperDual64>,
    moved: Vec<HyperDual64>,
    /// (δx, u + δu).
    z: Vec<HyperDual64>,
    ndx: usize,
}

impl<'a, D: Dynamics> SecondOrder<'a, D> {
    fn new(node: &'a Node<'a, D>, x: &[f64], u: &[f64]) -> Self {
        let ndx = node.dynamics.ndx();
        let zero = HyperDual64::from(0.0);
        let mut base = vec![zero; x.len()];
        lift_into(x, &mut base);
        let inputs = u.iter().map(|&u| HyperDual64::from(u));
        Self {
            node,
            moved: base.clone(),
            base,
            z: std::iter::repeat_n(zero, ndx).chain(inputs).collect(),
            ndx,
        }
    }

    fn in_directions(&mut self, i: usize, k: usize, cost: &Cost<D>) -> HyperDual64 {
        (self.z[i].eps1, self.z[k].eps2) = (1.0, 1.0);
        let out = self.cost(cost);
        (self.z[i].eps1, self.z[k].eps2) = (0.0, 0.0);
        out
    }

    fn cost(&mut self, cost: &Cost<D>) -> HyperDual64 {
        let (dx, u) = self.z.split_at(self.ndx);
        self.node
            .dynamics
            .integrate(&self.base, dx, &mut self.moved);
        let stage = self.node.stage;
        let terms = cost.terms.iter().filter(|term| term.counts_at(stage));
        terms.fold(HyperDual64::from(0.0), |sum, term| {
            let mut r = vec![HyperDual64::from(0.0); term.residual.dim(self.node.dynamics)];
            term.residual
                .second_order(self.node, &self.moved, u, &mut r);
            sum + Scalar::mul_add_real(
                term.activation.value(&r),
                term.weight,
                HyperDual64::from(0.0),
            )
        })
    }
}
