//! Batches on a GPU, where the package is built with the feature `cuda`.
//!
//! | file | what it is |
//! |---|---|
//! | `simulator` | the class `dualbody.cuda.Simulator` |
//! | `precision` | what it is made with, and the simulator in the precision that was asked for |
//! | `motions` | rollouts as numbers of arrays |

mod motions;
mod precision;
mod simulator;

pub(crate) use simulator::PyCudaSimulator;
