//! The terms of the equation of motion that are not the robot's own inertia: one file each, and one list.
//!
//! A step balances  M v̇ + h = τ + Σ Jᵀ f. Each term adds its part to τ, to the forces on bodies, to the implicit damping diagonal, or to the rows
//! whose forces a solver finds. For derivatives a term states the same over numbers with derivatives in its local inputs, and a sink converts these
//! to columns of A and B, or to a gradient. Only `list.rs` names all terms, so a new force is a file with the functions of [`Term`] and
//! [`TermDerivatives`], and a line there.
//!
//! | term | forces | rows |
//! |---|---|---|
//! | `drives` | inputs through motors, springs, dampers, smoothed friction | |
//! | `frame_forces` | external forces, frame actuators | |
//! | `constraints` | springs in place of rigid ones, at an instant | loops, welds, rods, tendons; springs over a step |
//! | `joint_limits` | at an instant, or linear in the velocity after the step | the same, beside a solver |
//! | `bounded_forces` | dry friction that holds, servos with a limit: over a step, each on a piece of its law | the same, beside a solver |
//! | `tendon_servos`, `frame_servos` | at an instant | over a step |
//! | `contact` | soft, at an instant | rigid; soft over a step |
//!
//! | sink | result |
//! |---|---|
//! | `jacobian` | derivatives of the acceleration in (q, v, contact state, u), column by column |
//! | `adjoint` | the gradient of a weighted acceleration |
//! | `numbers` | the gradient in the parameters of terms |

mod adjoint;
mod bilateral_row;
mod bounded_beside;
mod bounded_derivatives;
mod bounded_forces;
mod bounded_law;
mod bounded_rows;
mod chain;
mod columns;
mod constraint_derivatives;
mod constraints;
mod contact;
mod delassus;
mod drives;
mod frame_forces;
mod frame_servos;
mod jacobian;
mod joint_limits;
mod list;
mod local;
mod numbers;
mod place;
mod regularisation_derivatives;
mod rounds;
mod sink;
mod tendon_servos;
mod term;
mod tied_derivatives;
mod tied_joint;
mod weights;
mod yielding_derivatives;

pub(crate) use adjoint::{AdjointMemory, AdjointSink};
pub(crate) use columns::{RowColumns, add_turning, add_weighted_turning, turned_into};
pub(crate) use contact::{Contact, LEAST_SPEED, LoneImpact};
pub(crate) use jacobian::{ForceColumns, JacobianMemory, JacobianSink};
pub(crate) use list::{AllDerivatives, Terms};
pub(crate) use numbers::Numbers;
pub(crate) use sink::{Acting, DerivativePoint};
pub(crate) use term::{Term, TermDerivatives};
pub(crate) use weights::{StepGradientSum, TermWeights};
