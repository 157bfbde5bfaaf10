//! Contact of points with the ground: the term, the points that take part, and its derivatives.

mod adjoint;
mod columns;
mod over_numbers;
mod point;
mod rows;
mod working_set;

pub(crate) use adjoint::ContactAdjoint;
pub(crate) use columns::ContactColumns;
pub(crate) use rows::Contact;
