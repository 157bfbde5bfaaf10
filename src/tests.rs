//! Tolerances that unit tests share, each with its reason; the integration tests have the same ones.

/// A handful of operations on numbers of size one: some roundings of 1.1e-16 each. Ten times as much for a dozen operations.
pub(crate) const ROUNDING: f64 = 1e-15;
/// Two ways through the same algebra: roundings that add up over a whole formula.
pub(crate) const SAME_ALGEBRA: f64 = 1e-12;
/// Another algorithm for the same number, or an iteration that has converged: roundings of a whole robot, and of a linear solve.
pub(crate) const OTHER_ALGORITHM: f64 = 1e-9;
/// Extrapolated central differences: about eleven digits at inputs and derivatives of size one, less where curvature is large.
pub(crate) const FINITE_DIFFERENCE: f64 = 1e-8;
