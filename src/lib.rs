//! Differentiable multibody dynamics and robot simulation: **the physics is written once, over a scalar; everything else is a
//! choice of scalar.**
//!
//! A *scalar* is a number type. On `f64` the crate simulates, on [`Lanes`] it simulates many states at once. On dual numbers the same source gives exact
//! derivatives in state, input and the robot's own parameters. [`Simulator::linearize`] combines the derivatives of bodies and forces into A and B, the
//! Jacobians of the step, by the implicit function theorem. LQR and trajectory optimisation use A and B:
//!
//! ```
//! use dualbody::{Lqr, Simulator, State, model::samples};
//! use nalgebra::DMatrix;
//!
//! let simulator = Simulator::new(samples::cartpole()).with_time_step(0.01).with_actuated_joints(&["linear"])?;
//! let upright = State::neutral(simulator.model());
//! let step = simulator.linearize(&upright, &[0.0]);
//! let lqr = Lqr::discrete(&step.a, &step.b, &DMatrix::identity(4, 4), &DMatrix::from_element(1, 1, 0.01));
//! assert!(lqr.is_stabilized() && lqr.spectral_radius() < 1.0);
//! # Ok::<(), dualbody::UnknownName>(())
//! ```
//!
//! # Modules, in reading order
//!
//! | module | contents |
//! |---|---|
//! | [`scalar`] | the trait of number types that the physics is written over, without ordering; lanes, dual numbers over any scalar, expression [graphs](scalar::traced) |
//! | [`autodiff`] | drivers for Jacobians, gradients, Hessians, and the same by finite differences |
//! | [`least_squares`] | the method of Levenberg and Marquardt: bounds, robust losses, curved variables, covariance |
//! | [`cone`] | the solver of contact and constraint forces: bilateral, unilateral, in a friction cone; their derivatives |
//! | [`minimize`] | smooth functions minimised by argmin's methods (with `trajopt` or `identification`) |
//! | [`spatial`] | rotations, transforms, motions, forces, inertias |
//! | [`joint`] | the closed set of joint kinds, one file each |
//! | [`model`] | the robot: an immutable tree over model data, its builder, operations on it, the configuration manifold |
//! | [`io`] | description files: URDF, SDF and MJCF read, URDF and MJCF written; the only module that reads descriptions |
//! | [`dynamics`] | kinematics, RNEA, CRBA, ABA, Jacobians, energy: one file per algorithm; their derivatives along the tree |
//! | [`collision`] | distances of convex shapes: nearest features, then distance, points and normal over the scalar |
//! | [`constraint`] | closed loops: welds, ball joints, rods between attachment frames; couplers and tendons between joints |
//! | [`contact`] | contact points on the ground and between bodies, and contact models |
//! | [`sim`] | state, integrators, motors, friction and limits, thrusters and external forces, one step, a rollout, batches of them |
//! | [`linearize`] | A and B of the step in tangent coordinates; vector-Jacobian products of steps, gradients of rollouts |
//! | [`control`] | LQR over infinite and finite horizons, equilibria in contact, computed torque |
//! | [`trajopt`] | trajectory optimisation: problems, costs, differential dynamic programming, single shooting, direct transcription, model-predictive control |
//! | [`identify`] | system identification: logged motion, base parameters, physically consistent least squares, validation |
//! | [`memory`] | the limit on memory of results |
//! | [`view`] | recordings, their files, and an HTML viewer of the motion |
//! | [`codegen`] | the dynamics and the step of a robot as expression graphs, and as C |
//! | `command` | the program `dualbody` (with `cli`) |
//!
//! Units, frames, orders and signs: [`conventions`]. Terms and symbols: [`glossary`]. Literature: [`references`]. A guide for newcomers, in Rust and Python,
//! is in the folder `guide/` of the repository.
//!
//! # Features
//!
//! With `default-features = false` the crate has `codegen`, `memory` and the modules from `scalar` to `control` except `io` and `minimize`, for robots that are
//! [built](model::ModelBuilder) in code. Features that few programs need are off by default, since every program would compile them.
//!
//! | feature | default | adds |
//! |---|---|---|
//! | `formats` | yes | `io`: robots from URDF, SDF and MJCF files, meshes, files for other engines |
//! | `view` | yes | `view`: recordings, pages, tables (with `formats`) |
//! | `trajopt` | yes | `trajopt`: trajectory optimisation |
//! | `parallel` | yes | batches over all cores |
//! | `identification` | no | `identify`: system identification |
//! | `second-order` | no | Hessians of costs of rollouts, [exact curvature](trajopt::Curvature::Exact) of costs and steps |
//! | `graphs` | no | nothing new: the recorded functions of [`codegen`] are compiled with the library instead of with each program that calls them |
//! | `plot` | no | plots of recordings as SVG and PNG (with `view`) |
//! | `transcription` | no | direct transcription by Clarabel (with `trajopt`) |
//! | `live` | no | a simulation in the browser while it runs (with `view`) |
//! | `png` | no | height fields of MJCF files from PNG pictures (with `formats`) |
//! | `render` | no | pictures and animations of recordings without a browser: PNG and GIF (with `view`) |
//! | `cli` | no | the program `dualbody`: robots checked, shown, simulated and converted from a terminal (with `live`, `png`, `render`) |
//! | `full` | no | all of the above |
//! | `rerun` | no | motions in the Rerun viewer; compiles hundreds of crates |
//!
//! # Architecture invariants
//!
//! * Imports follow the order `scalar → autodiff, linalg → cone, least_squares, minimize → spatial → joint → model → dynamics → collision → constraint → contact → sim → linearize → control →
//!   trajopt → identify → io → view → codegen → command`: a module imports only modules before it. The private `input`, which opens files and parses XML, imports nothing. A test checks the order.
//! * Physics is written once; derivatives of forces and bodies come from the same source over dual numbers. Loops and branches in it depend on the structure of the model only; a decision on a value uses
//!   [`Scalar::select_lt`].
//! * Data that are computed from a model are in a workspace (scratch), not in the model. A workspace refuses a model whose parameters differ from those of its own model.
//! * Functions of `dynamics` with `_into` and `_at`, and [`Simulator::step_into`], do not allocate after set-up, except the first step with fast rotation.
//! * A wrong length is an error of the caller, and the public function panics. An invalid file is a [`LoadError`]. A numerical outcome is a status
//!   in the result.

#![forbid(unsafe_code)]
#![cfg_attr(
    not(all(feature = "view", feature = "trajopt")),
    allow(
        dead_code,
        unused_imports,
        reason = "for the features that are left out"
    )
)]

pub mod autodiff;
pub mod codegen;
pub mod collision;
#[cfg(feature = "cli")]
pub mod command;
pub mod cone;
pub mod constraint;
pub mod contact;
pub mod control;
pub mod dynamics;
pub mod error;
#[cfg(doctest)]
mod guide;
#[cfg(feature = "identification")]
pub mod identify;
#[cfg(feature = "formats")]
mod input;
#[cfg(feature = "formats")]
pub mod io;
pub mod joint;
pub mod least_squares;
mod linalg;
pub mod linearize;
pub mod memory;
#[cfg(any(feature = "trajopt", feature = "identification"))]
pub mod minimize;
pub mod model;
mod nested;
mod numbers;
mod parallel;
pub mod scalar;
pub mod sim;
mod sorting;
pub mod spatial;
mod special;
mod stop;
#[cfg(test)]
mod tests;
#[cfg(feature = "trajopt")]
pub mod trajopt;
#[cfg(feature = "view")]
pub mod view;

#[doc = include_str!("../guide/src/all_conventions.md")]
pub mod conventions {}

#[doc = include_str!("../guide/src/glossary.md")]
pub mod glossary {}

#[doc = include_str!("references.md")]
pub mod references {}

pub use contact::Contacts;
pub use control::Lqr;
pub use error::{
    EditError, InvalidState, LoadError, RecordingError, StructureMismatch, UnknownName, WriteError,
};
#[cfg(feature = "formats")]
pub use io::{ImportReport, ModelOptions};
pub use linearize::Linearization;
pub use model::{Base, Model, World};
#[cfg(feature = "parallel")]
#[doc(hidden)]
pub use parallel::beside_pool;
pub use scalar::{Cast, Lanes, Over, Scalar};
pub use sim::{Integrator, Simulator, State};
pub use stop::StopSignal;
#[cfg(feature = "trajopt")]
pub use trajopt::Ddp;
/// The crate whose `Robot` [`ModelOptions::load_urdf`] takes.
#[cfg(feature = "formats")]
pub use urdf_rs;
#[cfg(feature = "view")]
pub use view::Recording;

/// Compiles the example of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeDoctests;
