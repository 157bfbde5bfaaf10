//! Vector-Jacobian products of the dynamics: the gradient of a weighted sum of outputs in all inputs and parameters.
//!
//! The sum μᵀ ID(q, v, a) is a scalar; its gradient takes two passes along the tree, independent of the number of inputs ([`sweep`]). With the weight
//! μ = −M⁻¹ λ the same gradient is that of λᵀ FD(q, v, τ), by the implicit function theorem ([`forward_dynamics`]). Nothing is recorded.
//!
//! # References
//! [Griewank, Walther 2008, chapter 3].

mod energy;
mod forward_dynamics;
mod inverse_dynamics;
mod slots;
mod sweep;

pub(crate) use energy::{EnergyGradientSum, EnergySweep, Pushed, Rates};
pub use forward_dynamics::{
    ForwardDynamicsGradient, ForwardDynamicsVjpScratch, forward_dynamics_vjp,
    forward_dynamics_vjp_into,
};
pub use inverse_dynamics::{
    InverseDynamicsGradient, InverseDynamicsVjpScratch, inverse_dynamics_vjp,
    inverse_dynamics_vjp_into,
};
pub(crate) use slots::ParameterSlots;
pub(crate) use sweep::{Gradients, Sweep, Weighted};
