//! Trajectory optimisation: from a system, a cost and limits to the best trajectory, with feedback gains along it.
//!
//! A [`Problem`] puts together a [`System`] (a [`Simulator`](crate::Simulator) is one, any function of state and input written over the scalar
//! another), a horizon, a stage and a final [`Cost`], bounds on the inputs and [`Constraint`]s. Costs are sums of  w
//! a(r(x, u)):  a weight, an [`Activation`], a [`Residual`]; those of robots are here, a user's own is a function over
//! the scalar. Gradients and Gauss–Newton Hessians come by dual numbers, exact Hessians by hyper-dual numbers. States
//! live on their manifold: all derivatives are in the tangent space.
//!
//! [`Ddp`] solves it: differential dynamic programming in multiple-shooting form, with feedback gains.
//! [`RecedingHorizon`] does so over and over, as a controller. [`SingleShooting`] is the whole rollout as one function,
//! with its gradient and Hessian, for the methods of [`argmin`]: a yardstick, and a way to methods of one's own.
//! `Transcription` (feature `transcription`) solves the problem in continuous time, states and inputs of all nodes at
//! once: long steps, and path constraints held by a quadratic program.
//!
//! | question | solver | one iteration costs | reference |
//! |---|---|---|---|
//! | a trajectory with feedback gains | [`Ddp`] | O(N (`ndx` + `nu`)³) and the step Jacobians, allocates nothing | [Mastalli et al. 2020]; [Tassa, Mansard, Todorov 2014] |
//! | the same again at every step of a controller | [`RecedingHorizon`] | that of [`Ddp`] | [Tassa, Mansard, Todorov 2014] |
//! | the rollout as a function, for methods of one's own | [`SingleShooting`] | a rollout and its step Jacobians; with a Hessian O(N²) | [Griewank, Walther 2008] |
//! | long steps, many path constraints | `Transcription` | a sparse quadratic program | [Hargraves, Paris 1987]; [Kelly 2017] |
//!
//! Each has `…Options`, reports a [`Progress`] and ends with a [`Solution`] that has a [`Status`]; code over any of
//! them is written over [`Solver`].
//!
//! | question | answer |
//! |---|---|
//! | optimise a system of one's own? | [`System`]: its step over the scalar; derivatives come by dual numbers unless it has faster ones |
//! | keep an input within limits? | [`Problem::with_input_bounds`]; kept exactly, by [`SingleShooting`] through a smooth transform |
//! | keep a state within limits, softly? | [`Activation::Barrier`] on [`StateError`]; [`position_barrier`] |
//! | strictly, to a tolerance? | [`Problem::with_constraint`], with [`position_bounds`] |
//! | many of those, or between the steps too? | `Transcription` |
//! | end at a given state? | [`Problem::with_final_constraint`] |
//! | follow a reference? | [`StateError::along`], [`InputError::along`], a [`Schedule`] of any residual |
//! | follow one that goes on beyond the horizon? | the same, with [`Problem::set_first_stage`] |
//! | minimise some other function? | [`minimize`] |
//! | keep clear of a sphere? | [`FrameDistance`] within bounds, or in a barrier |
//! | of obstacles of any shape, and of oneself? | [`LinkDistances::at_least`], at nodes and between them; [`LinkDistances::barrier`] |
//! | let the start be chosen too? | [`InitialState::Free`] |
//!
//! Solvers see a system, a residual and a problem through pointers (`system/any.rs`, `residual.rs`) and are compiled once, in this library; a program
//! compiles what its own systems and residuals contain, and nothing else.

mod activation;
mod constraint;
mod cost;
mod curvature;
mod ddp;
mod lagrangian;
mod multipliers;
mod problem;
mod progress;
mod receding_horizon;
mod regularization;
mod residual;
mod residuals;
mod robot;
mod scratch;
mod shooting;
mod solution;
mod solver;
mod system;
#[cfg(test)]
mod tests;
mod trajectory;
#[cfg(feature = "transcription")]
mod transcription;

#[doc(no_inline)]
pub use crate::minimize::argmin;
#[doc(inline)]
pub use crate::minimize::{
    Differentiated, MinimizeOptions, Minimizer, Minimum, Objective, Status, minimize,
};
pub use activation::Activation;
pub use constraint::Constraint;
pub use cost::{Cost, Expansion};
pub use curvature::Curvature;
pub use ddp::{Ddp, DdpOptions, DdpSolution, Policy};
pub use multipliers::ConstraintOptions;
pub use problem::{InitialState, Problem};
pub use progress::Progress;
pub use receding_horizon::RecedingHorizon;
pub use regularization::RegularizationOptions;
pub use residual::{AnyResidual, Dependence, EvalOn, Node, Residual, ResidualJacobian};
pub use residuals::{
    CenterOfMass, CentroidalMomentum, FrameDistance, FrameOrientation, FramePose, FramePosition,
    FrameVelocity, InputError, LinkDistances, Obstacle, Schedule, StateError, effort_barrier,
    position_barrier, position_bounds, velocity_barrier,
};
pub use robot::Robot;
pub use scratch::Scratch;
pub use shooting::{ShootingOptions, ShootingSolution, SingleShooting, Variables};
pub use solution::Solution;
pub use solver::Solver;
pub use system::{AnySystem, AsSystem, Manifold, Sizes, System};
pub use trajectory::Trajectory;
#[cfg(feature = "transcription")]
pub use transcription::{
    Continuous, Curve, Transcription, TranscriptionOptions, TranscriptionSolution,
};
