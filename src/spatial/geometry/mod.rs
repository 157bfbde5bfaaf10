//! Shapes by their points: convex hulls, and a choice of points that keeps their extent.

mod candidates;
mod convex;
mod directions;
mod hull;

pub(crate) use hull::{hull, thinned};
