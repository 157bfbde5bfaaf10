//! Simulators: steps, rollouts, gradients, of one state and of batches.
//!
//! | file | what it is |
//! |---|---|
//! | `handle`, `questions` | the class `Simulator`, and how it pickles |
//! | `given`, `memory` | states and inputs of a call, working memory |
//! | `step`, `linearize` | one step, the acceleration at a moment, Jacobians |
//! | `contact`, `contact_frames`, `contact_forces` | what touches, where, and how hard |
//! | `rollout`, `single`, `batch`, `trajectories` | many steps |
//! | `batch_simulator`, `balance`, `spread` | states that stay in lanes, episodes of tasks that are data, on one thread or more |
//! | `native` | steps and Jacobians that are compiled |
//! | `gradient`, `rollout_gradient`, `weighted` | vector-Jacobian products of steps and rollouts |

mod balance;
mod batch;
mod batch_simulator;
mod contact;
mod contact_forces;
mod contact_frames;
mod given;
mod gradient;
mod handle;
mod linearize;
mod memory;
mod native;
mod questions;
mod rollout;
mod rollout_gradient;
mod single;
mod spread;
mod step;
mod trajectories;
mod weighted;

pub(crate) use balance::PyBalance;
pub(crate) use batch_simulator::PyBatchSimulator;
pub(crate) use contact_frames::entries;
#[cfg(feature = "cuda")]
pub(crate) use given::Given;
#[cfg(feature = "cuda")]
pub(crate) use given::read_inputs;
pub(crate) use given::{States, check_finite};
pub(crate) use gradient::pull_step;
pub(crate) use handle::{_simulator, PySimulator};
pub(crate) use native::PyNativeSimulator;
pub(crate) use step::{diverged, write_row};
#[cfg(feature = "cuda")]
pub(crate) use trajectories::{Status, status_of};
pub(crate) use weighted::Weighted;
