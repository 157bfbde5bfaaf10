//! Differentiable multibody dynamics.

pub mod autodiff;
pub mod control;
pub mod dynamics;
pub mod error;
pub mod joint;
pub mod linearize;
pub mod model;
pub mod scalar;
pub mod sim;
pub mod spatial;

pub use error::{LoadError, UnknownName};
pub use linearize::Linearization;
pub use model::Model;
pub use scalar::{Over, Scalar};
pub use sim::{Integrator, Simulator, State};
