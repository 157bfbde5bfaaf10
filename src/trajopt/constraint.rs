//! Constraints: residuals within bounds, and their augmented Lagrangian.

use std::fmt;

use super::activation::outside;
use super::cost::Expansion;
use super::dynamics::Dynamics;
use super::residual::{AnyResidual, Dependence, Node, Residual, ResidualJacobian};

/// lower ≤ r(x, u) ≤ upper, entry by entry: an equation where both bounds are the same, one-sided where one is infinite.
///
/// # Examples
/// ```
/// use dualbody::{Simulator, model::samples, trajopt::{Constraint, StateError}};
///
/// // the cart stays on its rail; the other coordinates are free
/// let simulator = Simulator::new(samples::cartpole());
/// let rail: Constraint<Simulator> = Constraint::within(
///     StateError::to_neutral(&simulator),
///     &[-1.0, f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY],
///     &[1.0, f64::INFINITY, f64::INFINITY, f64::INFINITY],
/// );
/// assert!((rail.violation(&simulator, 0, &[1.2, 0.0, 0.0, 0.0], &[]) - 0.2).abs() < 1e-15);
/// ```
pub struct Constraint<D> {
    residual: Box<dyn AnyResidual<D>>,
    lower: Vec<f64>,
    upper: Vec<f64>,
}

impl<D: Dynamics> Constraint<D> {
    /// lower ≤ r ≤ upper.
    ///
    /// # Panics
    /// If a lower bound is above its upper bound or not a number.
    pub fn within<R: Residual<D> + 'static>(residual: R, lower: &[f64], upper: &[f64]) -> Self {
        assert_eq!(lower.len(), upper.len(), "as many lower as upper bounds");
        let ordered = lower.iter().zip(upper).all(|(lower, upper)| lower <= upper);
        assert!(ordered, "a lower bound is above its upper bound");
        Self {
            residual: Box::new(residual),
            lower: lower.to_vec(),
            upper: upper.to_vec(),
        }
    }

    /// r = 0.
    pub fn equal_to_zero<R: Residual<D> + 'static>(dynamics: &D, residual: R) -> Self {
        let zeros = vec![0.0; Residual::dim(&residual, dynamics)];
        Self::within(residual, &zeros, &zeros)
    }

    /// Largest violation of the bounds over the entries of r. Allocates.
    pub fn violation(&self, dynamics: &D, stage: usize, x: &[f64], u: &[f64]) -> f64 {
        let mut memory = ResidualJacobian::new(dynamics, self.dim());
        let node = Node { dynamics, stage };
        self.largest_excess(&node, x, u, &mut memory)
    }

    /// The residual with its derivatives and its bounds, for solvers of other kinds.
    ///
    /// * `out` – output, made by [`ResidualJacobian::new`]
    pub fn linearize(
        &self,
        dynamics: &D,
        stage: usize,
        x: &[f64],
        u: &[f64],
        out: &mut ResidualJacobian,
    ) {
        out.prepare(self.dim());
        self.residual
            .linearize(&Node { dynamics, stage }, x, u, out);
    }

    /// Lower bounds, length `dim`.
    pub fn lower(&self) -> &[f64] {
        &self.lower
    }

    /// Upper bounds, length `dim`.
    pub fn upper(&self) -> &[f64] {
        &self.upper
    }

    /// Number of entries.
    pub fn dim(&self) -> usize {
        self.lower.len()
    }

    pub(super) fn check(&self, dynamics: &D, is_final: bool) {
        let dim = self.residual.dim(dynamics);
        assert_eq!(self.dim(), dim, "the bounds of a residual of {dim} entries");
        assert!(
            !is_final || self.residual.depends_on() != Dependence::Input,
            "a terminal constraint is about the input, which there is none of"
        );
    }

    pub(super) fn largest_excess(
        &self,
        node: &Node<'_, D>,
        x: &[f64],
        u: &[f64],
        memory: &mut ResidualJacobian,
    ) -> f64 {
        let r = self.residual(node, x, u, memory).iter();
        let bounds = self.lower.iter().zip(&self.upper);
        r.zip(bounds).fold(0.0, |largest, (&r, (&lower, &upper))| {
            // Not a number is a violation without limit.
            let excess = if r.is_nan() {
                f64::INFINITY
            } else {
                (r - upper).max(lower - r)
            };
            excess.max(largest)
        })
    }

    /// ½ μ dist(r + λ/μ, [lower, upper])², up to a constant the augmented Lagrangian.
    pub(super) fn penalty(
        &self,
        node: &Node<'_, D>,
        x: &[f64],
        u: &[f64],
        at: &Multipliers<'_>,
        memory: &mut ResidualJacobian,
    ) -> f64 {
        let r = self.residual(node, x, u, memory).iter();
        let terms = r.zip(at.lambda).enumerate().map(|(i, (&r, &lambda))| {
            let shifted = r + lambda / at.mu;
            at.mu * outside(shifted, self.lower[i], self.upper[i])
        });
        terms.sum()
    }

    /// Adds [`penalty`](Self::penalty) with its derivatives, the Hessian as Gauss and Newton have it.
    pub(super) fn add_penalty(
        &self,
        node: &Node<'_, D>,
        x: &[f64],
        u: &[f64],
        at: &Multipliers<'_>,
        memory: &mut ResidualJacobian,
        out: &mut Expansion,
    ) {
        memory.prepare(self.dim());
        self.residual.linearize(node, x, u, memory);
        for i in 0..self.dim() {
            let excess = self.shifted_excess(i, memory.values[i], at);
            if excess != 0.0 {
                out.value += 0.5 * at.mu * excess * excess;
                out.add_row(memory.row(i), at.mu * excess, at.mu);
            }
        }
    }

    /// λ ← μ (z − proj z) with z = r + λ/μ.
    pub(super) fn update_multipliers(
        &self,
        node: &Node<'_, D>,
        x: &[f64],
        u: &[f64],
        mu: f64,
        lambda: &mut [f64],
        memory: &mut ResidualJacobian,
    ) {
        self.residual(node, x, u, memory);
        for i in 0..self.dim() {
            let at = Multipliers { lambda, mu };
            let excess = self.shifted_excess(i, memory.values[i], &at);
            lambda[i] = mu * excess;
        }
    }

    /// z − proj z, signed, with z = r + λ/μ.
    fn shifted_excess(&self, i: usize, r: f64, at: &Multipliers<'_>) -> f64 {
        let z = r + at.lambda[i] / at.mu;
        z - z.clamp(self.lower[i], self.upper[i])
    }

    pub(super) fn residual<'m>(
        &self,
        node: &Node<'_, D>,
        x: &[f64],
        u: &[f64],
        memory: &'m mut ResidualJacobian,
    ) -> &'m [f64] {
        memory.values.resize(self.dim(), 0.0);
        self.residual.value(node, x, u, &mut memory.values);
        &memory.values
    }
}

impl<D> fmt::Debug for Constraint<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { lower, upper, .. } = self;
        write!(f, "Constraint({lower:?} ≤ r ≤ {upper:?})")
    }
}

/// The state of an augmented Lagrangian for one constraint at one stage.
pub(super) struct Multipliers<'a> {
    /// λ, length `dim`.
    pub(super) lambda: &'a [f64],
    /// μ > 0.
    pub(super) mu: f64,
}
