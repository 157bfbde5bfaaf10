//! Batches on a GPU, where the package is built with the feature `cuda`.
//!
//! | file | what it is |
//! |---|---|
//! | `simulator` | the class `dualbody.cuda.Simulator` |
//! | `precision` | what it is made with, and the simulator in the precision that was asked for |
//! | `motions` | rollouts as numbers of arrays |
//! | `states` | the class `dualbody.cuda.States`: states that stay on the GPU |
//! | `tensors` | arrays of other packages on the GPU |

mod motions;
mod precision;
mod simulator;
mod states;
mod tensors;

pub(crate) use simulator::PyCudaSimulator;
pub(crate) use states::PyCudaStates;
