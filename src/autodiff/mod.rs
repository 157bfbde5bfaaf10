//! Derivatives of functions that are written over the scalar, exact by dual numbers, and their finite-difference twin.
//!
//! A [`VectorFunction`] is evaluated on whichever scalar a driver needs: [`jacobian`], [`gradient`] and [`hessian`]
//! seed dual numbers; [`finite_difference::jacobian`] has the same signature and uses `f64` only, to check against, and
//! [`finite_difference::estimate`] says how exact it is. Directions are worked off in chunks of fixed width, so there
//! may be any number of them.
//!
//! # Choosing a method
//! Three ways lead through a motion: dual numbers that go along with the steps; the Jacobians A and B of each step
//! ([`linearize`](crate::Simulator::linearize)), which are multiplied afterwards; and vector-Jacobian products of the
//! steps ([`vjp`](crate::Simulator::vjp)), from the last to the first. All are exact, and give the same numbers.
//!
//! | robot | step with 4 directions | all Jacobians of the step | they cost as much as |
//! |---|---|---|---|
//! | cart-pole (2) | 7.6 | 5.8 | 3 directions |
//! | UR5 (6) | 4.2 | 3.5 | 3 |
//! | Panda (9) | 4.5 | 3.2 | 3 |
//! | quadruped (18) | 6.5 | 9.8 | 6 |
//! | humanoid (35) | 6.3 | 8.9 | 6 |
//! | quadruped on four feet, soft contact | 5.7 | 12 | 9 |
//! | the same, relaxed rigid contact | 4.9 | 7.6 | 6 |
//! | the same, rigid contact | 4.5 | 5.8 | 5 |
//!
//! In times of a step on plain numbers, on a busy machine; `cargo bench --bench derivatives -- '^(step|linearize)'`
//! measures them.
//!
//! * Few directions, fewer than in the last column, or up to four in any case: dual numbers, [`jacobian`] of a function
//!   that steps over the scalar; in parameters (masses, lengths, damping) of the many numbers of a whole trajectory by
//!   [`Model::with_some_parameters`](crate::Model::with_some_parameters).
//! * All of state and input, for feedback or for a solver that wants A and B: `linearize`.
//! * One number of a trajectory, a cost, in its start, all inputs and all parameters at once:
//!   [`Simulator::rollout_gradient`](crate::Simulator::rollout_gradient), some rollouts however many they are, less than
//!   dual numbers take for four directions; inside an optimiser
//!   [`SingleShooting::gradient`](crate::trajopt::SingleShooting::gradient), which does the same.
//! * Second derivatives of a trajectory: [`Simulator::rollout_hessian_product`](crate::Simulator::rollout_hessian_product).
//! * Other second derivatives: [`hessian`] is exact at n (n + 1) / 2 evaluations; differences of [`gradient`] have half its
//!   digits at 2 n.
//!
//! # How it is done
//! Drivers use [`Dual`]; the types of num-dual give the same numbers everywhere. The derivatives of the
//! [dynamics](crate::dynamics) use what is known of a robot instead: each body and joint runs on dual numbers by
//! itself, and the tree between them is eliminated.

pub mod finite_difference;
mod forward;
mod second_order;
mod tangent_point;

pub use crate::scalar::Dual;
pub use forward::{CHUNK, JacobianScratch, gradient, jacobian, jacobian_into};
pub use second_order::{SecondOrder, hessian};
pub(crate) use tangent_point::{TangentPoint, seed};

use crate::scalar::Scalar;

/// A function ℝⁿ → ℝᵐ, written once over the scalar.
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
