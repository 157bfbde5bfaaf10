//! The integrators: a folder each, with the step, its Jacobians (pushforward) and its gradient (pullback) side by side, and what they share.
//!
//! | module | content |
//! |---|---|
//! | `euler` | the step of Euler, semi-implicit or implicit in velocity |
//! | `runge_kutta_4` | the classical method of fourth order |
//! | `acceleration` | the acceleration at which all terms balance, which both evaluate |
//! | `half_step` | velocity forces of the middle of a step of Euler |
//! | `balance` | the gradient of the balance at an acceleration that has been found |
//! | `joint_tangents` | derivatives of the motion of one joint by itself |

mod acceleration;
mod balance;
mod euler;
mod half_step;
mod joint_tangents;
mod runge_kutta_4;
mod step_adjoint;

use nalgebra::DMatrix;

pub(crate) use acceleration::{AccelerationColumns, AccelerationScratch};
pub(crate) use euler::linearize as linearize_euler;
pub(crate) use joint_tangents::add_integrated;
pub(super) use runge_kutta_4::step as runge_kutta_4_step;
pub(crate) use runge_kutta_4::{StageColumns, Stages};
pub(crate) use step_adjoint::{StepAdjoint, StepPoint};

/// The Jacobians of a step, which are written:  δx⁺ = A δx + B δu.
pub(crate) struct StepColumns<'a, T> {
    /// A, `n_tangent` × `n_tangent`.
    pub(crate) a: &'a mut DMatrix<T>,
    /// B, `n_tangent` × `nu`.
    pub(crate) b: &'a mut DMatrix<T>,
}
