//! Tracing: numbers that record operations as expression graphs, for derivatives and code generation.
//!
//! A computation over [`Traced`] in [`trace`] becomes a [`Graph`] of the operations that depend on inputs. Parameters of a robot, a time step, a gain
//! are constants and are folded. The graph can be interpreted over any scalar ([`Graph::evaluate_into`]), differentiated ([`Graph::jacobian`],
//! [`Graph::gradient`], [`Graph::adjoint`]), counted and printed, and written as C ([`codegen`](crate::codegen)).
//!
//! | question | function | cost |
//! |---|---|---|
//! | record a computation? | [`trace`]; for standard functions [`codegen`](crate::codegen) | a look-up for each operation |
//! | size? | [`Graph::counts`], [`Graph::live_values`] | linear in the graph |
//! | evaluation? | [`Graph::evaluate`], [`Graph::evaluate_into`] without allocation | some nanoseconds for each operation |
//! | derivatives? | [`Graph::jacobian`]; for a scalar output, [`Graph::gradient`] | the gradient: a small multiple of the graph |
//! | C code? | [`Graph::to_c`](crate::codegen) | linear in the graph |
//!
//! # What can be traced
//! A graph has no branches and no loops: it performs the same operations for all inputs. So a computation must not depend on the *value* of a number,
//! except by [`select_lt`](crate::Scalar::select_lt), which is a node. Code that asks for a value panics with its location; constants have values.
//!
//! | | traced |
//! |---|---|
//! | kinematics, inverse dynamics, mass matrix, forward dynamics, Jacobians, energies, centroidal quantities, for all kinds of joints | yes |
//! | derivatives along the tree: [`inverse_dynamics_derivatives`](crate::dynamics::inverse_dynamics_derivatives), [`forward_dynamics_derivatives`](crate::dynamics::forward_dynamics_derivatives) | yes |
//! | a [step](crate::Simulator::step_into) of all integrators except the implicit midpoint rule, with springs, dampers, friction, motors | yes; semi-implicit Euler assumes that there is no fast rotation, see below |
//! | the same over dual numbers: A and B, derivatives in parameters | yes |
//! | in a model whose parameters are inputs | yes, as [`Model<Traced>`](crate::Model::cast) |
//! | soft contact, in explicit steps | yes |
//! | regularised rigid contact, kinematic constraints, in these steps | yes: by a fixed number of solver steps, see below |
//! | joint limits | yes; without contact or constraints, semi-implicit Euler releases pulling limits once, see below |
//! | [height fields](crate::contact::HeightField) of up to 4096 nodes, under corners | yes: the cell is found by comparisons with all nodes, four for each node and point |
//! | rigid contact, soft contact in steps of [implicit velocity](crate::Integrator::ImplicitVelocity), smoothed contact together with joint limits or bounded forces, [implicit midpoint](crate::Integrator::ImplicitMidpoint) | no: a solver searches on values |
//! | [contact between bodies](crate::Contacts::with_collisions): spheres, capsules, boxes and half-spaces against each other | yes, see below |
//! | contact between bodies with cylinders, ellipsoids, meshes, surfaces or distance fields, with smoothing or speculative contact | no: features are selected on values; the message names both shapes and links |
//! | [terrain](crate::contact::TerrainFunction) under corners and [forces](crate::sim::ForceFunction), given as functions | yes: the operations of the function, with all derivatives |
//! | shapes that roll on curved ground | no: the contact point is found on values |
//! | [`rollout`](crate::Simulator::rollout) | no, because it tests for divergence; a loop over steps can be traced |
//!
//! If an algorithm has a second branch for rare values, the graph contains the common branch with a [condition](Graph::conditions). Semi-implicit
//! Euler takes velocity forces from the middle of the step if a coordinate rotates faster than 100 rad/s and by more than 0.1 rad in a step (see
//! [`Integrator`](crate::Integrator)); it also releases pulling joint limits until none pulls, and the graph contains one such round. A fixed number
//! of interior-point steps finds the forces of regularised contact and of constraints, to a κ of 1e-11 of the squared size of the problem
//! ([`cone`](crate::cone)). All points take part; those above the ground have no force. The condition is that the steps have converged. Derivatives
//! use only the last step, so A and B do not grow with the number of steps. If a condition is violated, evaluation of the graph is an error, and
//! generated code returns a status.
//!
//! Two shapes that may touch have a fixed number of points: one for spheres and for two capsules, two for a capsule with a box or a half-space, four
//! for a box with a half-space, eight for two boxes. Distance, points and normal of every feature that could be the nearest are recorded, and selects
//! choose between them. So a step has the operations of all pairs of shapes, also of those that are far apart: exclude the pairs that never meet
//! ([`CollisionOptions::without`](crate::contact::CollisionOptions::without)). Points equal those of the library except where features are equally near, such as parallel capsules, and where a
//! box twenty times wider than high is so deep that its upper corners touch too.
//!
//! Traced numbers have no value, so parameters are not checked while they are traced. A square root of a negative number is then NaN.
//!
//! # Size and speed
//! Straight-line code grows with the robot, unlike the library's loops: one operation for each executed operation. The table shows
//! operations after folding, simultaneously alive results, milliseconds to trace, microseconds of a call in C and in the library, and seconds of the
//! C compiler, measured by `RUSTFLAGS='-C target-cpu=native' cargo bench --features codegen-tests --bench traced` on an AMD EPYC (family 25, model 1)
//! with gcc 12 (minimum of 40 rounds; degrees of freedom in brackets, with independent fingers of the Panda):
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
//! Ratios vary by a third and more from run to run: in the next run those of the UR5 were 0.44, 0.56 and 0.41, those of the Panda 0.62, 0.51 and 0.67.
//!
//! Steps with a force solver also contain the operations of the solver steps, which grow with the cube of the number of rows:
//!
//! | | operations | alive |
//! |---|---|---|
//! | four-bar linkage, closed by a ball joint | 441 | |
//! | ball on a slope, regularised rigid contact of one point | 6,280 | 79 |
//! | the same, A and B | 22,597 | |
//! | quadruped on four feet | 44,309 | 541 |
//! | the same with joint limits and a coupler | 373,709 | 2,800 |
//! | box on eight corners | 149,319 | 956 |
//! | the same, A and B | 469,637 | |
//!
//! In motions of 100 to 300 steps of these examples the solver always converged, and velocities after a step differ from those of the library by at
//! most 4.5e-7 of the change of velocity in the step (the quadruped with joint limits). A and B are those of the law at that κ: within 1e-6 of their
//! largest entry for the ball, and within 4e-5 for the box. In single precision the solver runs out of digits before convergence, and the condition
//! reports it (for the quadruped at each step in contact): compile such graphs in double precision.
//!
//! The code of the last row is too long for straight-line code: unlike the loops of the library it does not fit into caches.
//!
//! # Implementation
//! Each operation looks up its expression, so that no expression is recorded twice; exact rules fold constants (`recording.rs`).
//! Sine and cosine of one angle are one instruction; multiply-adds stay fused, with a single rounding as in [`mul_add`](crate::Scalar::mul_add).
//! Derivatives of a graph are the graph evaluated over dual numbers of traced numbers, or a recorded reverse sweep through its nodes.
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
