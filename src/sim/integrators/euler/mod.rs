//! The step of Euler, semi-implicit or implicit in velocity.

mod pullback;
mod pushforward;

pub(super) use pullback::add_gradient;
pub(crate) use pushforward::linearize;
