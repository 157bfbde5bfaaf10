//! Controllers: linear-quadratic regulators with the exact Jacobians of the step, equilibria, and computed torque.
//!
//! The public controllers are [`Lqr`] (infinite horizon), [`EquilibriumLqr`], [`FiniteHorizonLqr`] and [`ComputedTorque`]. The regulators use the
//! Riccati equation with its residual and Newton correction (`riccati.rs`), the doubling algorithm that solves it (`doubling.rs`), scaling of its
//! coordinates (`balance.rs`), checks of its weights (`weights.rs`), and rank tests that explain a failure (`stability.rs`,
//! `reachable_decomposition.rs`).
//!
//! | question | function | cost | reference |
//! |---|---|---|---|
//! | a gain that stabilises a fixed point? | [`Lqr::discrete`] on A and B of [`Simulator::linearize`](crate::Simulator::linearize) | 5 to 30 doublings of O(nx³) | [Chu, Fan, Lin and Wang 2004]; [Hewer 1971] |
//! | an equilibrium pose with its input? | [`Equilibrium::find`] | about 10 Jacobians of the step | [Levenberg 1944; Marquardt 1963] |
//! | stabilise it with feet on the ground? | [`Equilibrium::lqr`] | as above | [Van Dooren 1981] |
//! | in continuous time? | [`Lqr::continuous`] | the same, after an inverse of 2 nx | [Chu, Fan and Lin 2005]; [Kleinman 1968] |
//! | why did the design fail? | [`Lqr::status`] | | [Hautus 1969] |
//! | gains along a trajectory? | [`FiniteHorizonLqr::discrete`] | O(nx³) per stage | [Anderson and Moore 1990] |
//! | follow a target with all joints? | [`ComputedTorque`] | inverse dynamics, O(n) | [Murray, Li, Sastry 1994, section 4.5.2] |
//! | model-predictive control? | [`RecedingHorizon`](crate::trajopt::RecedingHorizon) | | |

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

pub use computed_torque::ComputedTorque;
pub use equilibrium::{Dropped, Equilibrium, EquilibriumLqr, EquilibriumStatus};
pub use finite_horizon::{FiniteHorizonLqr, FiniteHorizonStatus, LqrStage};
pub use lqr::{Lqr, LqrStatus};
pub use weights::WeightDefect;
