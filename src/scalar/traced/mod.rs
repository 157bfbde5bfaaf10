//! Numbers that record what is done with them: expression graphs, their derivatives, and code made of them.
//!
//! A computation over [`Traced`] inside of [`trace`] becomes a [`Graph`]: what is computed from the inputs and nothing
//! else. Parameters of a robot, a time step, a gain are constants, and fold away. The graph is interpreted over any
//! scalar ([`Graph::evaluate_into`]), differentiated ([`Graph::jacobian`], [`Graph::gradient`], [`Graph::adjoint`]),
//! counted and printed, and written as C ([`codegen`](crate::codegen)).
//!
//! | question | function |
//! |---|---|
//! | how is a computation recorded? | [`trace`]; of the usual ones [`codegen`](crate::codegen) |
//! | how large is it? | [`Graph::counts`], [`Graph::live_values`] |
//! | what does it compute? | [`Graph::evaluate`], [`Graph::evaluate_into`] without allocation |
//! | its derivatives? | [`Graph::jacobian`]; of one number in very many, [`Graph::gradient`] |
//! | as a program for other machines? | [`Graph::to_c`](crate::codegen) |
//!
//! # What can be traced
//! A graph has no branches and no loops: it holds for every input what it held when it was recorded. So nothing may
//! depend on the *value* of a number, but by [`select_lt`](crate::Scalar::select_lt), which is a node; what asks for a
//! value panics with the place that asked, and constants have theirs.
//!
//! | | traced |
//! |---|---|
//! | kinematics, inverse dynamics, mass matrix, forward dynamics, Jacobians, energies, centroidal quantities, for every kind of joint | yes |
//! | derivatives along the tree: [`inverse_dynamics_derivatives`](crate::dynamics::inverse_dynamics_derivatives), [`forward_dynamics_derivatives`](crate::dynamics::forward_dynamics_derivatives) | yes |
//! | a [step](crate::Simulator::step_into) of every integrator but the implicit midpoint rule, with springs, dampers, friction, motors | yes; a step of semi-implicit Euler assumes that nothing rotates fast, see below |
//! | the same over dual numbers: A and B, derivatives in parameters | yes |
//! | in a model whose numbers are inputs | yes, as [`Model<Traced>`](crate::Model::cast) |
//! | soft contact, in explicit steps | yes |
//! | relaxed rigid contact, kinematic constraints, in these steps | yes: a fixed number of steps to the forces, see below |
//! | joint limits | yes; without contact or constraints, pulling ones are released once in a step of semi-implicit Euler, see below |
//! | [height fields](crate::contact::HeightField) of up to 4096 nodes, under corners | yes: the cell is found by comparisons with all of them, four for each node and place |
//! | rigid contact, soft contact in steps of [implicit velocity](crate::Integrator::ImplicitVelocity), smoothed contact beside stops or bounded forces, [implicit midpoints](crate::Integrator::ImplicitMidpoint) | no: a solver searches on values |
//! | [contact between bodies](crate::Contacts::with_collisions) | no: which features touch is decided on values |
//! | [terrain](crate::contact::TerrainFunction) under corners and [forces](crate::sim::ForceFunction), given as functions | yes: what the function does, with all derivatives |
//! | shapes that roll on curved ground | no: the place is found on values |
//! | [`rollout`](crate::Simulator::rollout) | no, as it asks whether the motion diverges; a loop over steps is |
//!
//! Where an algorithm has a second branch for rare values, the graph is that of the ordinary ones and keeps the
//! [condition](Graph::conditions): semi-implicit Euler takes velocity forces from the middle of the step where a
//! coordinate turns faster than 100 rad/s and by more than 0.1 rad in a step (see [`Integrator`](crate::Integrator));
//! and it releases pulling joint limits until none pulls, of which the graph has one round.
//! Forces of relaxed contact and of constraints are found by a fixed number of steps of an interior-point method, to a κ of 1e-11 of the size of the
//! problem squared ([`cone`](crate::cone)); all points take part, those above the ground without a force. The condition is that the steps have
//! come near enough to the end. Derivatives come from the last step alone, so that A and B do not grow with the number of steps. Evaluating a graph where a
//! condition does not hold is an error, in generated code a return value.
//!
//! Numbers without a value cannot be checked: checks of parameters are left out while they are
//! traced. A root of a negative number is NaN then.
//!
//! # How large it gets
//! Straight-line code grows with the robot, unlike the library's loops: one operation for each executed operation. Operations
//! after folding, how many results are alive at once, milliseconds to trace, and microseconds of a call in C beside the
//! library, and seconds of the C compiler, as `RUSTFLAGS='-C target-cpu=native' cargo bench --features codegen-tests --bench traced` printed them on an
//! AMD EPYC (family 25, model 1) with gcc 12
//! (the least of 40 rounds; degrees of freedom in brackets, fingers of the Panda each by itself):
//!
//! | | operations | alive | ms | C, µs | library, µs | ratio | cc, s |
//! |---|---|---|---|---|---|---|---|
//! | UR5 (6), inverse dynamics | 511 | 59 | 0.6 | 0.221 | 0.391 | 0.56 | 0.3 |
//! | step | 1,127 | 94 | 1.3 | 0.318 | 0.753 | 0.42 | 0.4 |
//! | A and B | 3,903 | 208 | 4.4 | 2.436 | 2.902 | 0.84 | 1.7 |
//! | Panda (9), inverse dynamics | 962 | 97 | 0.5 | 0.300 | 0.673 | 0.45 | 0.3 |
//! | step | 2,049 | 129 | 1.4 | 0.698 | 2.043 | 0.34 | 0.7 |
//! | A and B | 9,361 | 467 | 8.3 | 3.443 | 6.726 | 0.51 | 4.6 |
//! | quadruped (18), inverse dynamics | 1,530 | 121 | 1.1 | 0.641 | 0.804 | 0.80 | 0.4 |
//! | step | 3,060 | 209 | 2.2 | 0.893 | 1.758 | 0.51 | 1.0 |
//! | A and B | 23,216 | 1,746 | 22.7 | 9.726 | 11.583 | 0.84 | 11.8 |
//! | humanoid (35), inverse dynamics | 3,927 | 281 | 2.9 | 1.140 | 1.387 | 0.82 | 1.0 |
//! | step | 8,912 | 456 | 7.0 | 2.619 | 2.759 | 0.95 | 2.4 |
//! | A and B | 90,698 | 6,906 | 81.9 | 41.838 | 28.455 | 1.47 | 71.6 |
//!
//! Ratios wander by a third and more from run to run: in the next one those of the UR5 were 0.44, 0.56 and 0.41, those of the Panda 0.62, 0.51 and 0.67.
//!
//! Steps with forces that a solver finds have as many operations more as its steps take, which grow with the cube of the number of rows:
//!
//! | | operations | alive |
//! |---|---|---|
//! | four-bar linkage, closed by a ball joint | 441 | |
//! | ball on a slope, relaxed rigid contact of one point | 6,280 | 79 |
//! | the same, A and B | 22,597 | |
//! | quadruped on four feet | 44,309 | 541 |
//! | the same among the stops of its joints, with a coupler | 373,709 | 2,800 |
//! | box on eight corners | 149,319 | 956 |
//! | the same, A and B | 469,637 | |
//!
//! Along motions of these, of 100 to 300 steps, all forces were found, and velocities after a step differ from the library's by at most 4.5e-7 of the
//! change of velocity in it (the quadruped among its stops). A and B are those of the law at that κ: of the ball within 1e-6 of their largest entry, of the
//! box within 4e-5. In single precision the path has no digits left before it ends, and the condition says so, of the quadruped at each step in contact:
//! compile such graphs in double.
//!
//! The last line is too long for straight-line code: it does not fit into caches, as the loops of the library do.
//!
//! # How it is done
//! Each operation looks up whether its expression is there already, so that none is recorded twice; rules that keep the
//! result fold what is known (`recording.rs`). Sine and cosine of one angle are one instruction; products with a sum
//! stay together, so that they are rounded once where [`mul_add`](crate::Scalar::mul_add) is. Derivatives of a graph are
//! the graph replayed over dual numbers of traced ones, or a sweep back through its nodes, which is recorded in turn.
//!
//! # References
//! [Griewank, Walther 2008]; [Curtis, Powell, Reid 1974] for the colours of Jacobians.

mod adjoint;
mod derivatives;
mod evaluate;
mod graph;
mod number;
mod operation;
mod port;
mod program;
mod recording;
mod schedule;
mod sparsity;
mod trace;

#[cfg(test)]
mod tests;

pub use evaluate::{BrokenCondition, EvaluationScratch};
pub use graph::{Counts, Graph, Origin};
pub use number::Traced;
pub use operation::{NodeId, Operation};
pub use port::Port;
pub use recording::Condition;
pub use trace::{Tracer, trace};
