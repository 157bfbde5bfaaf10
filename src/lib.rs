//! Differentiable multibody dynamics.

pub mod joint;
pub mod scalar;
pub mod spatial;
pub use scalar::{Over, Scalar};
