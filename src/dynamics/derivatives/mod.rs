//! Derivatives of the dynamics.
//!
//! Derivatives of inverse and forward dynamics use the structure of the robot: each body and joint is evaluated on dual numbers separately, and the
//! tree between them is eliminated ([`inverse_dynamics`]). They are generic over the scalar: plain numbers, several states at once
//! ([`Lanes`](crate::Lanes)), and dual numbers for derivatives in parameters or of second order. Other derivatives use the
//! [drivers](crate::autodiff).

mod blocks;
mod by_duals;
mod composite;
mod forward_dynamics;
mod inverse_dynamics;
mod joint;
mod propagate;
mod weightless;

pub(crate) use blocks::Blocks;
pub use by_duals::{
    StateDerivatives, center_of_mass_derivatives, centroidal_momentum_derivatives,
    centroidal_momentum_matrix_derivative, frame_placement_derivatives, frame_velocity_derivatives,
    inverse_dynamics_second_derivatives,
};
pub(crate) use forward_dynamics::AccelerationDerivatives;
pub use forward_dynamics::{
    ForwardDynamicsDerivatives, ForwardDynamicsDerivativesScratch, forward_dynamics_derivatives,
    forward_dynamics_derivatives_into,
};
pub(crate) use inverse_dynamics::{At, add_derivatives};
pub use inverse_dynamics::{
    InverseDynamicsDerivatives, InverseDynamicsDerivativesScratch, inverse_dynamics_derivatives,
    inverse_dynamics_derivatives_into,
};
pub(crate) use joint::{lifted, moved_by_own_tangents};
pub(crate) use propagate::Entries;
