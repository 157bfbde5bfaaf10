//! Rigid-body motion in space: rotations, transforms, motions, forces, inertias.
//!
//! A spatial vector is a pair of 3-vectors, *linear first*: a motion is (velocity of the point at the origin, angular velocity), a force is
//! (force, moment about the origin). Nothing here stores a 6 × 6 matrix; products are written out on 3-vectors.
//!
//! Names follow the monogram notation: `X_AB` is the pose of frame B in frame A and maps what is expressed in B to A, so that adjacent letters
//! cancel: `X_AC = X_AB * X_BC`.
//!
//! # References
//! [Featherstone 2008, chapter 2]; [Murray, Li, Sastry 1994, chapter 2].

pub(crate) mod linear;

mod articulated;
mod convection;
pub(crate) mod exponential;
mod force;
mod inertia;
mod motion;
mod parameters;
mod quaternion;
mod representation;
pub(crate) mod series;
mod symmetric;
pub(crate) mod transform;

pub use articulated::ArticulatedInertia;
pub(crate) use convection::{Convection, UnitConvections};
pub use force::Force;
pub use inertia::Inertia;
pub use motion::Motion;
pub use parameters::INERTIAL_PARAMETERS;
pub use quaternion::Quaternion;
pub(crate) use quaternion::rotation_vector;
pub use representation::Representation;
pub use symmetric::Symmetric3;
pub use transform::Transform;

/// Number of coordinates of a spatial vector.
pub const SPATIAL: usize = 6;
