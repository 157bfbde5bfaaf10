//! Remarks on a simulator: time steps that are too long, and friction laws that an integrator replaces.
//!
//! | module | content |
//! |---|---|
//! | `remark` | the remarks and their text |
//! | `soft_contact` | impacts of points of soft contact |
//! | `limits` | joint limits and speed limits in the Runge–Kutta method |
//! | `friction` | dry friction that an integrator smooths |
//! | `spring_damper` | longest stable steps of springs and dampers |
//!
//! Remarks that need Jacobians are in [`linearize`](crate::linearize).

mod friction;
mod limits;
mod remark;
mod soft_contact;
mod spring_damper;

pub use remark::{NaturalMode, SimulatorRemark};
