//! Derivatives of functions that are generic over the scalar: exact by dual numbers, and by finite differences as a check.
//!
//! A driver evaluates a [`VectorFunction`] on the scalar that it needs. With n inputs:
//!
//! | question | function | cost | reference |
//! |---|---|---|---|
//! | Jacobian of a function? | [`jacobian`], [`jacobian_into`] without allocation | n / 4 evaluations over [`Dual`], each 4 to 8 evaluations over `f64` | [Griewank, Walther 2008, chapter 3] |
//! | gradient of a function with one output? | [`gradient`] | the same | the same |
//! | value, gradient and Hessian? | [`hessian`] | n (n + 1) / 2 evaluations over hyper-dual numbers | [Fike, Alonso 2011] |
//! | Jacobian by finite differences, as a check? | [`finite_difference::jacobian`] | about twenty evaluations for each input | [Ridders 1982] |
//! | the same, with an estimate of its error? | [`finite_difference::estimate`] | the same | [Ridders 1982] |
//! | derivatives of the robot's dynamics, of a step, of a rollout? | [`dynamics`](crate::dynamics), [`linearize`](crate::linearize) | see there | |
//!
//! # Choosing a method
//! There are three methods to differentiate a motion: steps over dual numbers; products of the Jacobians A and B of each step
//! ([`linearize`](crate::Simulator::linearize)); and vector-Jacobian products of the steps ([`vjp`](crate::Simulator::vjp)), from the last to the
//! first. All are exact and give the same results.
//!
//! | robot | step with 4 directions | all Jacobians of the step | same cost as |
//! |---|---|---|---|
//! | cart-pole (2) | 7.6 | 5.8 | 3 directions |
//! | UR5 (6) | 4.2 | 3.5 | 3 |
//! | Panda (9) | 4.5 | 3.2 | 3 |
//! | quadruped (18) | 6.5 | 9.8 | 6 |
//! | humanoid (35) | 6.3 | 8.9 | 6 |
//! | quadruped on four feet, soft contact | 5.7 | 12 | 9 |
//! | the same, regularised rigid contact | 4.9 | 7.6 | 6 |
//! | the same, rigid contact | 4.5 | 5.8 | 5 |
//!
//! In units of a step on plain numbers, measured at commit 7fc50dd2 by `cargo bench --bench derivatives -- '^(step|linearize)'` on a shared machine of
//! two cores; `benches/RESULTS.md` has later measurements.
//!
//! * Few directions (fewer than in the last column, or up to four): dual numbers. Use [`jacobian`] of a function that steps over the scalar. For the
//!   derivatives of a whole trajectory in parameters (masses, lengths, damping), use it with
//!   [`Model::with_some_parameters`](crate::Model::with_some_parameters).
//! * All directions of state and input, for feedback or for a solver that needs A and B: `linearize`.
//! * The gradient of one cost of a trajectory in its start, all inputs and all parameters:
//!   [`Simulator::rollout_gradient`](crate::Simulator::rollout_gradient). It costs a few rollouts, less than dual numbers for four directions. Inside
//!   an optimiser use [`SingleShooting::gradient`](crate::trajopt::SingleShooting::gradient).
//! * Second derivatives of a trajectory: [`Simulator::rollout_hessian_product`](crate::Simulator::rollout_hessian_product).
//! * Other second derivatives: [`hessian`] is exact at n (n + 1) / 2 evaluations; differences of [`gradient`] have half its
//!   digits at 2 n.
//!
//! # Implementation
//! Directions are evaluated in chunks of fixed width; their number is arbitrary. Drivers use [`Dual`]; the types of num-dual give the same results. The derivatives of the [dynamics](crate::dynamics) use the
//! structure of the robot instead: each body and joint is evaluated on dual numbers separately, and the tree between them is eliminated.

pub mod finite_difference;
mod forward;
mod second_order;
mod tangent_point;

pub use crate::scalar::Dual;
pub use forward::{CHUNK, JacobianScratch, gradient, jacobian, jacobian_into};
pub use second_order::{SecondOrder, hessian};
pub(crate) use tangent_point::{TangentPoint, seed};

use crate::scalar::Scalar;

/// A function ℝⁿ → ℝᵐ, generic over the scalar.
///
/// # Examples
/// ```
/// use dualbody::{Scalar, autodiff::{VectorFunction, jacobian}};
///
/// /// Polar to Cartesian coordinates.
/// struct Polar;
/// impl VectorFunction for Polar {
///     fn n_outputs(&self) -> usize {
///         2
///     }
///     fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
///         let (sin, cos) = x[1].sin_cos();
///         (y[0], y[1]) = (x[0] * cos, x[0] * sin);
///     }
/// }
/// let j = jacobian(&Polar, &[2.0, 0.0]);
/// assert_eq!(j.as_slice(), [1.0, 0.0, 0.0, 2.0]);
/// ```
pub trait VectorFunction {
    /// Number of outputs m.
    fn n_outputs(&self) -> usize;

    /// Computes `y` (length [`n_outputs`](Self::n_outputs)) from `x`.
    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]);
}
