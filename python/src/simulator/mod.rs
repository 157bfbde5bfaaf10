//! Simulators: steps, rollouts, gradients, of one state and of batches.
//!
//! | file | what it is |
//! |---|---|
//! | `handle`, `questions` | the class `Simulator`, and how it pickles |
//! | `given`, `memory` | states and inputs of a call, working memory |
//! | `step`, `contact` | one step, its Jacobians, what touches |
//! | `rollout`, `inputs`, `single`, `batch`, `trajectories` | many steps |

mod batch;
mod contact;
mod given;
mod handle;
mod inputs;
mod memory;
mod questions;
mod rollout;
mod single;
mod step;
mod trajectories;

pub(crate) use handle::{_simulator, PySimulator};
