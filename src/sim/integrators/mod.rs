//! The integrators: a folder each, with the step, its Jacobians (pushforward) and its gradient (pullback) side by side, and what they share.
//!
//! | module | content |
//! |---|---|
//! | `euler` | the Euler step, semi-implicit or linearly implicit, with isolated impacts |
//! | `runge_kutta_4` | the classical method of fourth order |
//! | `implicit_midpoint` | the implicit midpoint rule, which keeps energy |
//! | `acceleration` | the acceleration at which all terms balance, which the first two evaluate |
//! | `kick_drift` | motion of all joints in which velocities change over one time and positions over another one |
//! | `half_step` | velocity forces in the middle of an Euler step |
//! | `balance` | derivatives of the balance of forces at a given acceleration |
//! | `joint_tangents` | derivatives of the motion of a single joint |
//! | `bilateral` | equations of motion with bilateral rows |
//! | `tree_lu` | factors of matrices that have the zeros of the tree and no symmetry |
//! | `activated` | any method behind the activations of inputs |
//! | `method` | the traits of a method |
//! | `list` | the list of methods: another one is a folder, a variant of [`Integrator`](super::Integrator), and a line there |

mod acceleration;
mod activated;
mod balance;
mod bilateral;
mod euler;
mod half_step;
mod implicit_midpoint;
mod joint_tangents;
mod kick_drift;
mod list;
mod method;
mod runge_kutta_4;
mod tree_lu;

pub(crate) use acceleration::{
    AccelerationColumns, AccelerationScratch, FoundMotions, KnownAcceleration,
};
#[cfg(feature = "second-order")]
pub(crate) use joint_tangents::add_integrated;
pub(crate) use list::{StepAdjoint, StepJacobian, StepMemory};
pub(crate) use method::{Pullback, Pushforward, Step, StepColumns, StepPoint};
pub(crate) use runge_kutta_4::linear_factor;
