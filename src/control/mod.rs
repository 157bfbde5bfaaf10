//! Controllers: linear-quadratic regulators on the step's exact Jacobians, and computed torque on the model itself.
//!
//! [`Lqr`] (infinite horizon), [`FiniteHorizonLqr`] and [`ComputedTorque`] are what a user calls. Behind the regulators
//! stand the Riccati equation with its residual and Newton correction (`riccati.rs`), the doubling algorithm that
//! solves it (`doubling.rs`), the balancing of its coordinates (`balance.rs`), the checks of its weights
//! (`weights.rs`), and the rank tests that explain a failure (`stability.rs`, `reachable_decomposition.rs`).
//!
//! | question | function | cost | reference |
//! |---|---|---|---|
//! | a gain that holds a fixed point? | [`Lqr::discrete`] on A and B of [`Simulator::linearize`](crate::Simulator::linearize) | 5 to 30 doublings of O(nx³) | [Chu, Fan, Lin and Wang 2004]; [Hewer 1971] |
//! | a pose that can be held, and with which input? | [`Equilibrium::find`] | some 10 Jacobians of the step | [Levenberg 1944; Marquardt 1963] |
//! | hold it with feet on the ground? | [`Equilibrium::lqr`] | as above | [Van Dooren 1981] |
//! | in continuous time? | [`Lqr::continuous`] | the same, after an inverse of 2 nx | [Chu, Fan and Lin 2005]; [Kleinman 1968] |
//! | why is there none? | [`Lqr::status`] | | [Hautus 1969] |
//! | gains along a trajectory? | [`FiniteHorizonLqr::discrete`] | O(nx³) a stage | [Anderson and Moore 1990] |
//! | follow a target with all joints? | [`ComputedTorque`] | inverse dynamics, O(n) | [Murray, Li, Sastry 1994, section 4.5.2] |
//! | plan, and plan again? | [`RecedingHorizon`](crate::trajopt::RecedingHorizon) | | |

mod balance;
mod computed_torque;
mod doubling;
mod equilibrium;
mod finite_horizon;
mod lqr;
mod reachable_decomposition;
mod riccati;
mod stability;
mod triple;
mod weights;

pub use computed_torque::{ComputedTorque, ComputedTorqueScratch};
pub use equilibrium::{Dropped, Equilibrium, EquilibriumLqr, EquilibriumStatus};
pub use finite_horizon::{FiniteHorizonLqr, FiniteHorizonStatus, LqrStage};
pub use lqr::{Lqr, LqrStatus};
pub use weights::WeightDefect;
