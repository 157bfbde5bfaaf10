//! The gradient of the balance of forces and rows at an acceleration that has been found.

mod pullback;
mod rows;
mod weights;

pub(super) use pullback::BalanceAdjoint;
pub(super) use weights::{AccelerationWeights, Balanced, HeldWeights};
