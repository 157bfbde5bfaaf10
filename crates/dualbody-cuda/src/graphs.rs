//! The functions of a robot that kernels are made of, as graphs: those of [`dualbody::codegen`], with parameters of the robot as inputs where a batch is of many
//! variants of it. Any other graph becomes a kernel in the same way ([`CudaFunction`](crate::CudaFunction)).

pub use dualbody::codegen::{
    feedback_step, forward_dynamics, inverse_dynamics, linearization, linearization_of_variants,
    step_adjoint, step_of_variants as step,
};
