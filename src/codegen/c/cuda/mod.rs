//! The writer of CUDA: the statements of the writer of C, in kernels with one state per thread.

mod batch;
mod places;
mod rollout;
mod source;
mod stages;

pub use places::CudaSizes;
pub use rollout::RolloutInputs;
pub use source::{CudaKernel, CudaSource};
