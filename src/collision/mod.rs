//! Distances of convex shapes: which features are nearest, then distance, points and normal over the scalar.
//!
//! There are two stages. [`nearest_features`] and [`features`] select a vertex, edge, face, rim or surface of each shape, on plain values.
//! [`witness`] computes distance, points and normal from these features by closed forms over the scalar: exact in poses and sizes, with derivatives
//! of any order that the scalar carries.
//!
//! Points are in the world, the first shape's first; the normal is from the first shape to the second; the distance of overlapping shapes is the
//! negative length of the shortest translation that separates them.
//!
//! | question | function | cost | reference |
//! |---|---|---|---|
//! | which shapes? | [`Shape`]: sphere, capsule, box, cylinder, ellipsoid, [`Hull`], triangle, half-space, [`DistanceField`] | | |
//! | a shape of any form, by a function? | [`DistanceField`], a user's [`DistanceFunction`] | that of the function | |
//! | which features are nearest? | [`nearest_features`] | closed forms, or a few steps of a search | [Gilbert, Johnson, Keerthi 1988] |
//! | where do shapes touch? | [`features`], a [`Manifold`] of at most [`MAX_POINTS`] | the same, and a polygon cut by another | [Sutherland, Hodgman 1974] |
//! | distance, points, normal? | [`witness`] | closed forms | |
//! | ground of arbitrary shape, fixed to the world? | [`Surface`], a triangle mesh | O(log n) for n triangles, and the triangles that are near | |
//! | distance from a point, volume, inertia? | [`Shape::distance_to_point`], [`Shape::volume`], [`Shape::inertia`] | closed forms, for a hull linear in its faces | |
//! | which pairs can touch? | [`BroadPhase`] of [`Bounds`], [`Groups`] | O(n log n) for n shapes | |
//!
//! # References
//! [Gilbert, Johnson, Keerthi 1988]; [van den Bergen 2001].

mod bounds;
mod broad_phase;
mod clip;
mod corner;
mod ends;
mod feature;
mod field;
mod field_pairs;
mod groups;
mod guard;
mod hull;
mod measures;
mod nearest;
mod newton;
mod patch;
mod placed;
mod point_cylinder;
mod ray;
mod recorded;
mod rounded;
mod search;
mod segments;
mod shape;
mod solid;
mod surface;
mod witness;

pub use bounds::Bounds;
pub use broad_phase::{BroadPhase, TooManyPairs};
pub use feature::{
    Face, Feature, FeatureId, MAX_POINTS, Manifold, NormalSource, PairFeature, Witness,
};
pub use field::{DistanceField, DistanceFunction};
pub use groups::Groups;
pub use hull::{Hull, HullError};
pub use nearest::{features, nearest_features};
pub(crate) use ray::HalfLine;
pub(crate) use recorded::{recorded_feature, recorded_points, recorded_witness};
pub(crate) use rounded::{NOTHING, each_rounded, excess};
pub use shape::Shape;
pub(crate) use surface::TriangleSides;
pub use surface::{Surface, SurfaceError};
pub use witness::witness;
