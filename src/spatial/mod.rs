//! Spatial algebra: rotations, transforms, motions, forces, inertias.
//!
//! A spatial vector is a pair of 3-vectors, *linear first*: a motion is
//! (velocity of the point at the origin, angular velocity), a force is (force, moment about the origin). No type stores a 6 × 6 matrix; products are
//! written out for 3-vectors.
//!
//! Names follow the monogram notation: `X_AB` is the pose of frame B in frame A and maps quantities expressed in B to A, so adjacent letters cancel:
//! `X_AC = X_AB * X_BC`.
//!
//! All functions take constant time and do not allocate:
//!
//! | question | type, function | reference |
//! |---|---|---|
//! | pose of a frame, transformation of vectors? | [`Transform`]: [`point`](Transform::point), [`motion`](Transform::motion), [`force`](Transform::force), [`inertia`](Transform::inertia) | [Featherstone 2008, 2.8] |
//! | as 6 × 6 matrices? | [`Transform::adjoint`], [`Transform::force_adjoint`] | [Murray, Li, Sastry 1994, 2.4] |
//! | roll, pitch and yaw? | [`Quaternion::from_roll_pitch_yaw`], [`Quaternion::to_roll_pitch_yaw`] | |
//! | rotation? | [`Quaternion`], [`Quaternion::to_matrix`], [`Quaternion::from_matrix`] | [Shepperd 1978] |
//! | pose after a constant velocity, and back? | [`Transform::exp`], [`Transform::log`], [`Quaternion::exp`], [`Quaternion::log`] | [Murray, Li, Sastry 1994, chapter 2] |
//! | velocity of a body? | [`Motion`], [`Motion::cross`] | [Featherstone 2008, 2.2] |
//! | force and power? | [`Force`], [`Motion::cross_force`], [`Motion::power`] | [Featherstone 2008, 2.3] |
//! | inertia? | [`Inertia`], [`Inertia::times`], [`Inertia::from_com`] | [Featherstone 2008, 2.13] |
//! | inertia of an articulated body? | [`ArticulatedInertia`] | [Featherstone 2008, 7.1] |
//! | unconstrained inertial parameters? | [`Inertia::from_log_cholesky`], [`Inertia::to_pseudo_inertia`] | [Rucker, Wensing 2022]; [Wensing, Kim, Slotine 2018] |
//! | axes and origin of expression? | [`Representation`] | |
//!
//! # References
//! [Featherstone 2008, chapter 2]; [Murray, Li, Sastry 1994, chapter 2].

pub(crate) mod linear;

mod adjoint;
mod articulated;
pub(crate) mod exponential;
mod force;
pub(crate) mod geometry;
mod inertia;
mod motion;
mod parameters;
mod quaternion;
mod representation;
mod roll_pitch_yaw;
pub(crate) mod series;
mod symmetric;
pub(crate) mod transform;
mod vector;
mod velocity_product;

pub use articulated::ArticulatedInertia;
pub use force::Force;
pub use inertia::Inertia;
pub use motion::Motion;
pub use parameters::INERTIAL_PARAMETERS;
pub use quaternion::Quaternion;
pub(crate) use quaternion::rotation_vector;
pub use representation::Representation;
#[cfg(feature = "formats")]
pub(crate) use roll_pitch_yaw::roll_pitch_yaw;
pub use symmetric::Symmetric3;
pub use transform::Transform;
pub(crate) use velocity_product::{UnitVelocityProducts, VelocityProductMatrix};

/// Number of coordinates of a spatial vector: three linear ones, then three angular ones.
pub const SPATIAL: usize = 6;
