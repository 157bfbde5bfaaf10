//! Trajectory optimisation: finds the optimal trajectory of a system for a cost and constraints, with feedback gains.
//!
//! A [`Problem`] consists of a [`System`] (a [`Simulator`](crate::Simulator), or any function of state and input over the scalar), a horizon, a stage
//! cost and a final [`Cost`], bounds on the inputs and [`Constraint`]s. Costs are sums of w a(r(x, u)): a weight, an [`Activation`], a [`Residual`].
//! Residuals of robots are in this module; a user-defined residual is a function over the scalar. Gradients and Gauss–Newton Hessians use dual
//! numbers, exact Hessians hyper-dual numbers. States are on their manifold: all derivatives are in the tangent space.
//!
//! [`Ddp`] solves it: differential dynamic programming in multiple-shooting form, with feedback gains.
//! [`RecedingHorizon`] solves it at each step, as a model-predictive controller. [`SingleShooting`] is the rollout as one function, with its gradient
//! and Hessian, for the methods of [`argmin`]: for comparison, and for custom methods. `Transcription` (feature `transcription`) is direct
//! collocation: it solves the problem in continuous time for the states and inputs of all nodes at once, with long steps, and path constraints in a
//! quadratic program.
//!
//! | question | solver | one iteration costs | reference |
//! |---|---|---|---|
//! | a trajectory with feedback gains | [`Ddp`] | O(N (`ndx` + `nu`)³) and the step Jacobians, allocates nothing | [Mastalli et al. 2020]; [Tassa, Mansard, Todorov 2014] |
//! | model-predictive control | [`RecedingHorizon`] | as [`Ddp`] | [Tassa, Mansard, Todorov 2014] |
//! | the rollout as a function, for custom methods | [`SingleShooting`] | a rollout and its step Jacobians; with a Hessian O(N²) | [Griewank, Walther 2008] |
//! | long steps, many path constraints | `Transcription` | a sparse quadratic program | [Hargraves, Paris 1987]; [Kelly 2017] |
//!
//! Each has `…Options`, reports a [`Progress`] and ends with a [`Solution`] that has a [`Status`]; generic code uses the trait [`Solver`].
//!
//! | question | answer |
//! |---|---|
//! | optimise a custom system? | [`System`]: its step over the scalar; derivatives use dual numbers by default |
//! | keep an input within limits? | [`Problem::with_input_bounds`]; satisfied exactly, in [`SingleShooting`] by a smooth transform |
//! | keep a state within limits, softly? | [`Activation::Barrier`] on [`StateError`]; [`position_barrier`] |
//! | keep a state within limits, to a tolerance? | [`Problem::with_constraint`], with [`position_bounds`] |
//! | many path constraints, also between the steps? | `Transcription` |
//! | end at a given state? | [`Problem::with_final_constraint`] |
//! | follow a reference? | [`StateError::along`], [`InputError::along`], a [`Schedule`] of any residual |
//! | follow a reference beyond the horizon? | the same, with [`Problem::set_first_stage`] |
//! | minimise another function? | [`minimize`] |
//! | keep clear of a sphere? | [`FrameDistance`] within bounds, or in a barrier |
//! | keep clear of obstacles of any shape, and of other links? | [`LinkDistances::at_least`], at nodes and between them; [`LinkDistances::barrier`] |
//! | optimise the initial state? | [`InitialState::Free`] |
//!
//! Solvers use systems, residuals and problems through trait objects (`system/any.rs`, `residual.rs`) and are compiled once, in this library; a
//! program compiles only its own systems and residuals.

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
