//! Differentiable multibody dynamics.

pub mod error;
pub mod joint;
pub mod model;
pub mod scalar;
pub mod spatial;

pub use error::{LoadError, UnknownName};
pub use model::Model;
pub use scalar::{Over, Scalar};
