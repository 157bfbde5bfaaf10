//! Contact of points with the ground and between bodies: the term, the points that take part, and its derivatives.

mod asleep;
mod forces;
mod impact;
mod kept;
mod numbers;
mod pairs;
mod places;
mod point;
mod point_on_bodies;
mod rows;
mod seeds;
mod slopes;
mod solved;
mod start;
mod time_step;
mod touching;
mod working_set;

pub(crate) use impact::{LEAST_SPEED, LoneImpact};
pub(crate) use rows::Contact;
pub(crate) use slopes::ContactDerivatives;
