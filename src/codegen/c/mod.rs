//! The writer of C, and of CUDA.

mod body;
mod cuda;
mod expression;
mod function;
mod header;
mod names;
mod parts;
mod precision;
mod source;

pub use cuda::{CudaKernel, CudaSizes, CudaSource, RolloutInputs};
pub use names::CodeError;
pub use precision::Precision;
pub use source::Source;
