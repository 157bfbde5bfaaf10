//! Contact of points with the ground: the term, the points that take part, and its derivatives.

mod numbers;
mod point;
mod rows;
mod slopes;
mod solved;
mod time_step;
mod working_set;

pub(crate) use rows::Contact;
pub(crate) use slopes::ContactSlopes;
