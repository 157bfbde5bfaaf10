//! Nonlinear least squares: min ½ Σᵢ ρ(rᵢ(x)²), within bounds, by the Levenberg–Marquardt method.
//!
//! With m residuals and n variables:
//!
//! | question | function | cost | reference |
//! |---|---|---|---|
//! | minimise residuals? | [`solve`], [`solve_with`] | an iteration: the residuals, their Jacobian, O(m n² + n³) | [Levenberg 1944; Marquardt 1963; Moré 1978] |
//! | keep variables within bounds? | [`Options::with_bounds`] | | |
//! | residuals over the scalar, Jacobian by dual numbers? | [`ByDuals`] | that of [`jacobian`](crate::autodiff::jacobian) | |
//! | residuals with their own Jacobian, working memory or variables? | [`Residuals`] | | |
//! | some measurements are wrong? | [`Loss`] | O(m) | [Huber 1964; Triggs et al. 2000] |
//! | uncertainty of the variables? | [`Solution::covariance`] | O(n³) | |
//!
//! A step d of the variables solves  min ½ ‖J d + r‖² + ½ λ ‖D d‖²  within the bounds. D are the largest norms of the columns of J so far, so the
//! units of the variables do not matter. The step is taken if the cost decreases nearly as predicted; λ decreases or grows accordingly. Far from
//! the solution this is a descent method; near it, the Gauss–Newton method, which converges quadratically for zero residuals and linearly for small
//! ones.

mod loss;
mod options;
mod residuals;
mod solution;
mod solver;
mod system;

pub use loss::Loss;
pub use options::Options;
pub use residuals::{ByDuals, Residuals};
pub use solution::{Iteration, Solution, Status};
pub use solver::{solve, solve_with};

#[cfg(test)]
mod tests;
