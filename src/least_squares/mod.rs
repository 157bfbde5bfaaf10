//! Nonlinear least squares: min ½ Σᵢ ρ(rᵢ(x)²), within bounds, by Levenberg and Marquardt's method.
//!
//! | question | answer | reference |
//! |---|---|---|
//! | which variables make residuals small? | [`solve`] | [Levenberg 1944; Marquardt 1963; Moré 1978] |
//! | residuals over the scalar, Jacobian by dual numbers | [`ByDuals`] | |
//! | residuals with a Jacobian, working memory or variables of their own | [`Residuals`] | |
//! | some measurements are wrong | [`Loss`] | [Huber 1964; Triggs et al. 2000] |
//! | how certain are the variables? | [`Solution::covariance`] | |
//!
//! A step d of the variables solves  min ½ ‖J d + r‖² + ½ λ ‖D d‖²  within the bounds, where D are the largest lengths that the columns of J have had,
//! so that it does not matter in which units variables are. It is taken if the cost falls as predicted, or nearly; λ falls or grows with that. Far from
//! the solution this is a descent, near it Gauss and Newton's method, which converges quadratically where residuals vanish and linearly where they are
//! small.

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
