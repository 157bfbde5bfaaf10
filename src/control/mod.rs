//! Controllers: linear-quadratic regulators on the step's exact Jacobians, and computed torque on the model itself.
//!
//! [`Lqr`] (infinite horizon), [`FiniteHorizonLqr`] and [`ComputedTorque`] are what a user calls. Behind the regulators stand the
//! Riccati equation with its residual and Newton correction (`riccati.rs`), the doubling algorithm that solves it
//! (`doubling.rs`), the balancing of its coordinates (`balance.rs`), the checks of its weights (`weights.rs`), and the rank tests
//! that explain a failure (`stability.rs`, `staircase.rs`).

mod balance;
mod computed_torque;
mod doubling;
mod finite_horizon;
mod lqr;
mod riccati;
mod stability;
mod staircase;
mod triple;
mod weights;

pub use computed_torque::{ComputedTorque, ComputedTorqueScratch};
pub use finite_horizon::{FiniteHorizonLqr, FiniteHorizonStatus, LqrStage};
pub use lqr::{Lqr, LqrStatus};
pub use weights::WeightDefect;
