//! The terms of the equation of motion that are not the robot's own inertia: one file each, and one list.
//!
//! A step balances  M v̇ + h = τ + Σ Jᵀ f. Each term adds its part to τ, to the forces on bodies, to the diagonal beside M, or to the rows
//! whose forces a solver finds; and its part of the derivatives of all that. The list in `list.rs` is the only place that names all of them: the
//! step ([`Simulator::step_into`](crate::Simulator::step_into)) and its Jacobians
//! ([`Simulator::linearize_into`](crate::Simulator::linearize_into)) go over it, so a new force is a file with the functions of [`Term`],
//! [`TermDerivatives`] and [`TermAdjoint`], and a line.
//!
//! | term | forces | rows |
//! |---|---|---|
//! | `drives` | inputs through motors, springs, dampers, friction | |
//! | `frame_forces` | external forces, frame actuators | |
//! | `constraints` | | loops, welds, rods |
//! | `stops` | at a moment, or linear in the velocity after the step | the same, beside a solver |
//! | `contact` | soft, at a moment | rigid; soft over a step |

mod adjoint;
mod chain;
mod columns;
mod constraint_adjoint;
mod constraints;
mod contact;
mod drives;
mod frame_forces;
mod held_rows;
mod linear_point;
mod list;
mod moved;
mod place;
mod stops;
mod term;

pub(crate) use adjoint::{AdjointPoint, RowWeights, StepSlopes, TermAdjoint};
pub(crate) use columns::{RowColumns, add_turning, add_weighted_turning, turned_into};
pub(crate) use constraint_adjoint::HeldWeights;
pub(crate) use contact::ContactAdjoint;
pub(crate) use held_rows::{Bias, Held};
pub(crate) use linear_point::{Coordinates, ForceColumns, LinearPoint};
pub(crate) use list::{TermAdjoints, TermColumns, Terms};
pub(crate) use term::{Term, TermDerivatives};
