//! Remarks on a simulator: time steps that are too long.
//!
//! | module | content |
//! |---|---|
//! | `remark` | the remarks, and their text |
//! | `soft_contact` | impacts of points of soft contact |
//! | `limits` | joint limits and speed limits in Runge and Kutta's method |
//! | `spring_damper` | longest stable steps of these |
//!
//! Remarks that need Jacobians are in [`linearize`](crate::linearize).

mod limits;
mod remark;
mod soft_contact;
mod spring_damper;

pub use remark::{NaturalMode, SimulatorRemark};
