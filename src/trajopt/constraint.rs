//! Constraints: residuals within bounds, and their augmented Lagrangian.

use std::fmt;

use super::activation::outside;
use super::cost::Expansion;
use super::cost::terms::Point;
use super::residual::{BoundResidual, Erased};
use super::residual::{Dependence, Residual, ResidualJacobian};
use super::system::System;

/// lower ≤ r(x, u) ≤ upper, entry by entry: an equation where both bounds are the same, one-sided where one is
/// infinite.
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
    residual: Erased<D>,
    bounds: Bounds,
}

/// lower ≤ r ≤ upper, entry by entry.
#[derive(Clone, Debug)]
pub(super) struct Bounds {
    pub(super) lower: Vec<f64>,
    pub(super) upper: Vec<f64>,
}

/// Takes a constraint: its bounds, its residual on its system.
pub(super) type ConstraintVisitor<'a> = dyn FnMut(&Bounds, &dyn BoundResidual) + 'a;

impl<D: System> Constraint<D> {
    /// lower ≤ r ≤ upper.
    ///
    /// # Panics
    /// If a lower bound is above its upper bound or not a number.
    pub fn within<R: Residual<D> + 'static>(residual: R, lower: &[f64], upper: &[f64]) -> Self {
        assert_eq!(lower.len(), upper.len(), "as many lower as upper bounds");
        let ordered = lower.iter().zip(upper).all(|(lower, upper)| lower <= upper);
        assert!(ordered, "a lower bound is above its upper bound");
        Self {
            residual: residual.erase(),
            bounds: Bounds {
                lower: lower.to_vec(),
                upper: upper.to_vec(),
            },
        }
    }

    /// Makes an equality constraint r(x, u) = 0 of all entries of a residual.
    pub fn equal_to_zero<R: Residual<D> + 'static>(dynamics: &D, residual: R) -> Self {
        let zeros = vec![0.0; Residual::dim(&residual, dynamics)];
        Self::within(residual, &zeros, &zeros)
    }

    /// Largest violation of the bounds over the entries of r. Allocates.
    pub fn violation(&self, dynamics: &D, stage: usize, x: &[f64], u: &[f64]) -> f64 {
        let mut memory = ResidualJacobian::new(dynamics, self.dim());
        let residual = self.residual.on(dynamics);
        self.bounds
            .largest_excess(&residual, Point { stage, x, u }, &mut memory)
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
        self.residual.on(dynamics).linearize(stage, x, u, out);
    }

    /// Lower bounds, length `dim`.
    pub fn lower(&self) -> &[f64] {
        &self.bounds.lower
    }

    /// Upper bounds, length `dim`.
    pub fn upper(&self) -> &[f64] {
        &self.bounds.upper
    }

    /// Number of entries of the residual.
    pub fn dim(&self) -> usize {
        self.bounds.dim()
    }

    pub(super) fn check(&self, dynamics: &D, is_final: bool) {
        let dim = self.residual.dim(dynamics);
        assert_eq!(self.dim(), dim, "the bounds of a residual of {dim} entries");
        assert!(
            !is_final || self.residual.depends_on() != Dependence::Input,
            "a terminal constraint is about the input, which there is none of"
        );
    }

    /// Hands out the constraint, on its system.
    pub(super) fn visit(&self, dynamics: &D, visit: &mut ConstraintVisitor<'_>) {
        visit(&self.bounds, &self.residual.on(dynamics));
    }
}

impl Bounds {
    /// Number of entries of the residual.
    pub(super) fn dim(&self) -> usize {
        self.lower.len()
    }

    /// Largest violation over the entries; infinite where one is not a number.
    pub(super) fn largest_excess(
        &self,
        residual: &dyn BoundResidual,
        at: Point<'_>,
        memory: &mut ResidualJacobian,
    ) -> f64 {
        let r = self.residual(residual, at, memory).iter();
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
        residual: &dyn BoundResidual,
        at: Point<'_>,
        multipliers: &Multipliers<'_>,
        memory: &mut ResidualJacobian,
    ) -> f64 {
        let (lambda, mu) = (multipliers.lambda, multipliers.mu);
        let r = self.residual(residual, at, memory).iter();
        let terms = r.zip(lambda).enumerate().map(|(i, (&r, &lambda))| {
            let shifted = r + lambda / mu;
            mu * outside(shifted, self.lower[i], self.upper[i])
        });
        terms.sum()
    }

    /// Adds [`penalty`](Self::penalty) with its derivatives, the Hessian as Gauss and Newton have it.
    pub(super) fn add_penalty(
        &self,
        residual: &dyn BoundResidual,
        at: Point<'_>,
        multipliers: &Multipliers<'_>,
        memory: &mut ResidualJacobian,
        out: &mut Expansion,
    ) {
        let mu = multipliers.mu;
        memory.prepare(self.dim());
        residual.linearize(at.stage, at.x, at.u, memory);
        for i in 0..self.dim() {
            let excess = self.shifted_excess(i, memory.values[i], multipliers);
            if excess != 0.0 {
                out.value += 0.5 * mu * excess * excess;
                out.add_row(memory.row(i), mu * excess, mu);
            }
        }
    }

    /// λ ← μ (z − proj z) with z = r + λ/μ.
    pub(super) fn update_multipliers(
        &self,
        residual: &dyn BoundResidual,
        at: Point<'_>,
        mu: f64,
        lambda: &mut [f64],
        memory: &mut ResidualJacobian,
    ) {
        self.residual(residual, at, memory);
        for i in 0..self.dim() {
            let excess = self.shifted_excess(i, memory.values[i], &Multipliers { lambda, mu });
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
        residual: &dyn BoundResidual,
        at: Point<'_>,
        memory: &'m mut ResidualJacobian,
    ) -> &'m [f64] {
        memory.values.resize(self.dim(), 0.0);
        residual.value(at.stage, at.x, at.u, &mut memory.values);
        &memory.values
    }
}

impl<D> fmt::Debug for Constraint<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Bounds { lower, upper } = &self.bounds;
        write!(f, "Constraint({lower:?} ≤ r ≤ {upper:?})")
    }
}

/// Multipliers of the constraints of a stage, or of one of them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Multipliers<'a> {
    /// λ, one constraint after the other.
    pub(super) lambda: &'a [f64],
    /// μ > 0.
    pub(super) mu: f64,
}

impl<'a> Multipliers<'a> {
    /// Multipliers of the constraint whose λ begins at `first`, which moves on to the next one.
    pub(super) fn part(&self, first: &mut usize, dim: usize) -> Self {
        let lambda: &'a [f64] = &self.lambda[*first..*first + dim];
        *first += dim;
        Self {
            lambda,
            mu: self.mu,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: ([f64; 2], [f64; 2]) = ([-1.0, 2.0], [1.0, 2.0]);

    fn excess(i: usize, r: f64, lambda: f64) -> f64 {
        let bounds = Bounds {
            lower: BOUNDS.0.to_vec(),
            upper: BOUNDS.1.to_vec(),
        };
        let lambda = [lambda; 2];
        let at = Multipliers {
            lambda: &lambda,
            mu: 10.0,
        };
        bounds.shifted_excess(i, r, &at)
    }

    // z = r + λ/μ less its projection on the bounds: of an inequality −1 ≤ r ≤ 1, and of an equality r = 2.
    #[test]
    fn shifted_excess_is_the_distance_of_z_from_its_bounds() {
        assert_eq!(excess(0, 0.5, 2.0), 0.0);
        assert_eq!(excess(0, 0.75, 5.0), 0.25);
        assert_eq!(excess(0, -1.5, 2.5), -0.25);
        assert_eq!(excess(1, 2.0, 5.0), 0.5);
        assert_eq!(excess(1, 1.5, 0.0), -0.5);
    }

    #[test]
    fn multipliers_of_constraints_are_handed_out_one_after_the_other() {
        let all = Multipliers {
            lambda: &[1.0, 2.0, 3.0],
            mu: 4.0,
        };
        let mut first = 0;
        assert_eq!(all.part(&mut first, 1).lambda, [1.0]);
        let second = all.part(&mut first, 2);
        assert_eq!((second.lambda, second.mu, first), (&[2.0, 3.0][..], 4.0, 3));
    }
}
