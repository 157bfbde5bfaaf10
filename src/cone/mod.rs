//! Forces of contacts and constraints: one solver for bilateral, unilateral, bounded and frictional rows.
//!
//! Find f with y = (G + diag R) f + g such that the law of each block holds: y = 0, or 0 ≤ f ⊥ y ≥ 0, or y = 0 within a force bound, or friction in a
//! cone, either convex or Coulomb's law with De Saxcé's correction, or a moment within a multiple of the normal force of a cone. The solver combines seven ideas:
//!
//! * **First guess.** Of a few regularised rows, those that approach stick and the others are separated. If the forces for which this holds obey all laws,
//!   they are the solution, in all lanes at once.
//! * **Active set.** Each law says  f = Π(f − ŷ), and the projection Π on the cone is smooth on each of three pieces: separated, sticking, sliding;
//!   that on an interval has three pieces as well: at either bound, and between. Newton's method on the active set, the pieces that hold at the last
//!   forces, needs few steps, and often one from a warm start.
//! * **Proximal steps.** If the active set cycles because of redundant contacts, springs between the forces and their last values make the problem
//!   regular; they are weakened step by step.
//! * **Path.** If this fails too, an interior-point method follows the smooth problem f ∘ ŷ = κ e for decreasing κ until it identifies the active
//!   set. At a fixed κ > 0 the same problem is a smoothed law with derivatives everywhere.
//! * **Blocks.** A pile of bodies has many rows, each on two bodies. G = Xᵀ X is then never formed: Newton's matrices are those of the bodies, in
//!   sparse blocks. If the active set is not found, descent with a line search in the coordinates of the bodies leads near it.
//! * **Recorded numbers.** A graph cannot branch: for [traced](crate::scalar::traced) numbers the solver follows the path for a fixed number of
//!   steps, and convergence is a condition of the graph.
//! * **Implicit derivatives.** All decisions use values in `f64`. Over any scalar, steps with the same factorised matrix on the active pieces give
//!   exact derivatives in G, R, g and μ, of any order.
//!
//! Moments couple to their cone by the derivative of their bound in the normal force alone: the active set has it, the path leaves moments to the
//! active set, and sparse blocks and recorded numbers have none.
//!
//! The laws do not depend on a model: rows can be contacts, joint limits, closed loops.
//!
//! | question | answer | cost for n rows | reference |
//! |---|---|---|---|
//! | which problem? | [`ConeProblem`] of [`Block`]s, each with a [`Law`] | G has n × n entries | [De Saxcé & Feng 1998] |
//! | its forces, and their derivatives? | [`ConeSolver::solve`] | O(n³) per step; no step from the solution, few from nearby, otherwise a few tens | [Alart & Curnier 1991] |
//! | with derivatives before touch-down? | [`ConeOptions::with_smoothing`] | the steps of the path | [Howell et al. 2022] |
//! | how accurate are they? | [`Certificate`], [`Status`] | | |
//! | active piece of each law? | [`ConeSolver::modes`], [`Mode`] | | |
//!
//! # References
//! [De Saxcé & Feng 1998]; [Alart & Curnier 1991]; [Acary, Cadoux, Lemaréchal, Malick 2011]; [Tasora & Anitescu 2011];
//! [Rockafellar 1976; Carpentier, Le Lidec & Montaut 2024] for proximal steps;
//! [Castro, Permenter & Han 2022] for velocities as unknowns; [Davis 2006] for the order of elimination;
//! [Le Lidec, Jallet, Montaut, Laptev, Schmid, Carpentier 2024]; [Howell et al. 2022] for the central path of Coulomb's law.

mod block_factor;
mod blocks;
mod by_blocks;
mod certificate;
mod descent;
mod implicit;
mod interior;
mod interval;
mod jacobian;
mod lane;
mod law;
mod newton;
mod problem;
mod proximal;
mod recorded;
mod response;
mod search;
mod second_order_cone;
mod sensitivity;
mod smoothed;
mod solver;
mod sticking;
mod system;
#[cfg(test)]
mod tests;
mod transposed;

pub(crate) use blocks::Columns;
pub use certificate::{Certificate, Mode, Status};
pub(crate) use problem::BlockProblem;
pub use problem::{Block, ConeProblem, Law};
pub use smoothed::Smoothed;
pub use solver::{ConeOptions, ConeSolver, REGULARIZATION};
