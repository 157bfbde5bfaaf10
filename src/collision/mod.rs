//! Distances of convex shapes: which features are nearest, then distance, points and normal over the scalar.
//!
//! The work is in two parts. [`nearest_features`] and [`features`] decide on plain values which vertex, edge, face, rim or surface of each shape takes part.
//! [`witness`] computes from these features, by a few closed forms over the scalar, distance, points and normal: exact in poses and sizes, with derivatives of
//! any order that the scalar carries.
//!
//! Points are in the world, the first shape's first; the normal is from the first shape to the second; a distance is negative where shapes overlap, and is then
//! the least translation that separates them.
//!
//! | question | answer |
//! |---|---|
//! | which shapes? | [`Shape`]: sphere, capsule, box, cylinder, ellipsoid, [`Hull`], triangle, half-space |
//! | which features are nearest? | [`nearest_features`] |
//! | where do shapes touch? | [`features`], a [`Manifold`] of at most [`MAX_POINTS`] |
//! | how far, where, along which normal? | [`witness`] |
//! | ground of any shape, fixed to the world? | [`Surface`], a mesh of triangles |
//! | how far from a point, how large, how heavy? | [`Shape::distance_to_point`], [`Shape::volume`], [`Shape::inertia`] |
//! | which pairs can touch at all? | [`BroadPhase`] of [`Bounds`], [`Groups`] |
//!
//! # References
//! [Gilbert, Johnson, Keerthi 1988]; [van den Bergen 2001].

mod bounds;
mod broad_phase;
mod clip;
mod feature;
mod groups;
mod guard;
mod hull;
mod measures;
mod nearest;
mod newton;
mod patch;
mod placed;
mod point_cylinder;
mod search;
mod segments;
mod shape;
mod solid;
mod surface;
mod witness;

pub use bounds::Bounds;
pub use broad_phase::{BroadPhase, TooManyPairs};
pub use feature::{Face, Feature, FeatureId, MAX_POINTS, Manifold, NormalSource, PairFeature};
pub use groups::Groups;
pub use hull::{Hull, HullError};
pub use nearest::{features, nearest_features};
pub use shape::Shape;
pub(crate) use surface::TriangleSides;
pub use surface::{Surface, SurfaceError};
pub use witness::{Witness, witness};
