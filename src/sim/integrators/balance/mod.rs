//! The balance of forces and rows at fixed accelerations and forces of rows: its derivatives column by column, and the gradient of its weighted sum.

mod pullback;
mod pushforward;

pub(super) use pullback::BalanceAdjoint;
pub(super) use pushforward::BalanceColumns;
