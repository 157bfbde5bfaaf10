//! Constraints: residuals within bounds, and their augmented Lagrangian.

use std::fmt;

use super::activation::outside;
use super::cost::{Expansion, Point};
use super::residual::{AnyResidual, Dependence, Node, Residual, ResidualJacobian};
use super::system::{AnySystem, AsSystem};

/// lower ≤ r(x, u) ≤ upper, entry by entry: an equality if both bounds are equal, one-sided if one is infinite.
///
/// # Examples
/// ```
/// use dualbody::{Simulator, model::samples, trajopt::{Constraint, StateError}};
///
/// // the cart stays on its rail; the other coordinates are free
/// let simulator = Simulator::new(samples::cartpole());
/// let rail = Constraint::within(
///     StateError::to_neutral(&simulator),
///     &[-1.0, f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY],
///     &[1.0, f64::INFINITY, f64::INFINITY, f64::INFINITY],
/// );
/// # let _ = rail;
/// ```
pub struct Constraint {
    residual: Box<dyn AnyResidual>,
    lower: Vec<f64>,
    upper: Vec<f64>,
}

/// Checks that lower bounds are numbers, and at most the upper ones.
///
/// # Panics
/// If one is not.
pub(super) fn check_bounds(lower: &[f64], upper: &[f64]) {
    for (k, (lower, upper)) in lower.iter().zip(upper).enumerate() {
        let is_number = !lower.is_nan() && !upper.is_nan();
        assert!(
            is_number,
            "bound {k} from {lower} to {upper} is not a number"
        );
        assert!(
            lower <= upper,
            "lower bound {k}, {lower}, is above its upper bound {upper}"
        );
    }
}

impl Constraint {
    /// lower ≤ r ≤ upper.
    ///
    /// # Panics
    /// If a lower bound is above its upper bound or NaN.
    pub fn within<R: Residual>(residual: R, lower: &[f64], upper: &[f64]) -> Self {
        assert_eq!(lower.len(), upper.len(), "as many lower as upper bounds");
        check_bounds(lower, upper);
        Self {
            residual: residual.boxed(),
            lower: lower.to_vec(),
            upper: upper.to_vec(),
        }
    }

    /// Makes an equality constraint r(x, u) = 0 of all entries of a residual.
    pub fn equal_to_zero<R: Residual>(dynamics: &(impl AsSystem + ?Sized), residual: R) -> Self {
        let zeros = vec![0.0; residual.dim(&Node::new(dynamics, 0))];
        Self::within(residual, &zeros, &zeros)
    }

    /// Computes the residual with its derivatives, for other solvers.
    ///
    /// * `out` – output, made by [`ResidualJacobian::new`]
    pub fn linearize(
        &self,
        dynamics: &(impl AsSystem + ?Sized),
        stage: usize,
        x: &[f64],
        u: &[f64],
        out: &mut ResidualJacobian,
    ) {
        self.linearize_at(Point::new(dynamics.as_system(), stage, x, u), out);
    }

    /// Lower bounds, length `dim`.
    #[cfg(feature = "transcription")]
    pub(crate) fn lower(&self) -> &[f64] {
        &self.lower
    }

    /// Upper bounds, length `dim`.
    #[cfg(feature = "transcription")]
    pub(crate) fn upper(&self) -> &[f64] {
        &self.upper
    }

    /// Number of entries of the residual.
    pub(crate) fn dim(&self) -> usize {
        self.lower.len()
    }

    pub(super) fn check(&self, system: &dyn AnySystem, is_final: bool) {
        let dim = self.residual.dim(&Node::new(system, 0));
        assert_eq!(self.dim(), dim, "the bounds of a residual of {dim} entries");
        assert!(
            !is_final || self.residual.depends_on() != Dependence::Input,
            "a terminal constraint is about the input, but the last stage has no input"
        );
    }

    /// The residual with its derivatives.
    pub(super) fn linearize_at(&self, at: Point<'_>, out: &mut ResidualJacobian) {
        out.prepare(self.dim());
        self.residual.linearize(&at.node(), at.x, at.u, out);
    }

    /// The residual.
    pub(super) fn values<'m>(&self, at: Point<'_>, memory: &'m mut ResidualJacobian) -> &'m [f64] {
        memory.values.resize(self.dim(), 0.0);
        let r = &mut memory.values;
        self.residual.value(&at.node(), at.x, at.u, r);
        r
    }

    /// Largest violation over the entries; infinite where one is NaN.
    pub(super) fn largest_excess(&self, at: Point<'_>, memory: &mut ResidualJacobian) -> f64 {
        let r = self.values(at, memory).iter();
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
        at: Point<'_>,
        multipliers: &Multipliers<'_>,
        memory: &mut ResidualJacobian,
    ) -> f64 {
        let (lambda, mu) = (multipliers.lambda, multipliers.mu);
        let r = self.values(at, memory).iter();
        let terms = r.zip(lambda).enumerate().map(|(i, (&r, &lambda))| {
            let shifted = r + lambda / mu;
            mu * outside(shifted, self.lower[i], self.upper[i])
        });
        terms.sum()
    }

    /// Adds [`penalty`](Self::penalty) with its derivatives, the Hessian as Gauss and Newton have it.
    pub(super) fn add_penalty(
        &self,
        at: Point<'_>,
        multipliers: &Multipliers<'_>,
        memory: &mut ResidualJacobian,
        out: &mut Expansion,
    ) {
        let mu = multipliers.mu;
        self.linearize_at(at, memory);
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
        at: Point<'_>,
        mu: f64,
        lambda: &mut [f64],
        memory: &mut ResidualJacobian,
    ) {
        for (i, &r) in self.values(at, memory).iter().enumerate() {
            let excess = self.shifted_excess(i, r, &Multipliers { lambda, mu });
            lambda[i] = mu * excess;
        }
    }

    /// z − proj z, signed, with z = r + λ/μ.
    fn shifted_excess(&self, i: usize, r: f64, at: &Multipliers<'_>) -> f64 {
        let z = r + at.lambda[i] / at.mu;
        z - z.clamp(self.lower[i], self.upper[i])
    }
}

impl fmt::Debug for Constraint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { lower, upper, .. } = self;
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
    use crate::trajopt::StateError;

    const BOUNDS: ([f64; 2], [f64; 2]) = ([-1.0, 2.0], [1.0, 2.0]);

    fn excess(i: usize, r: f64, lambda: f64) -> f64 {
        let bounds = Constraint::within(StateError::to(&[0.0; 2]), &BOUNDS.0, &BOUNDS.1);
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
