//! Code generation: dynamics and step of a robot as expression graphs, C and CUDA.
//!
//! The functions here record the library's computations as expression graphs. [`trace`](crate::scalar::traced::trace) records any other computation.
//! [`scalar::traced`](crate::scalar::traced) lists what can be traced, sizes and times.
//!
//! | question | function | cost | source |
//! |---|---|---|---|
//! | joint forces, accelerations, M as a graph? | [`inverse_dynamics`], [`forward_dynamics`], [`mass_matrix`] | below 3 ms to record, for up to 35 degrees of freedom | [Griewank, Walther 2008] |
//! | derivatives of joint forces? | [`inverse_dynamics_derivatives`] | some milliseconds | the same |
//! | a step, with A and B? | [`step`], [`linearization`] | 1 to 7 ms, 4 to 82 ms | the same |
//! | the same for variants of a robot, with parameters as inputs? | [`step_of_variants`], [`linearization_of_variants`] | the same | |
//! | a step under linear feedback, the gradient of a step? | [`feedback_step`], [`step_adjoint`] | a small multiple of the step | the same, chapter 3 |
//! | C code? | [`Graph::to_c`](crate::scalar::Graph::to_c) | linear in the graph | |
//! | CUDA code for thousands of states? | [`Graph::to_cuda`](crate::scalar::Graph::to_cuda), [`Graph::to_cuda_rollout`](crate::scalar::Graph::to_cuda_rollout) | linear in the graph | |
//! | check the robot of a graph? | [`check_origin`] | O(n) | |
//!
//! # The C code
//! The code is C99, for microcontrollers and for other languages. It depends on `math.h` only, and allocates nothing. It has two functions:
//!
//! * `int NAME(const NAME_real *in, NAME_real *out)` – all inputs in one array, all outputs in another; the header contains their offsets. It returns
//!   0, or the index, from 1, of the first violated [condition](crate::scalar::Graph::conditions).
//! * `size_t NAME_batch(size_t count, const NAME_real *in, NAME_real *out, int *status)` – evaluates states in sequence, with contiguous inputs of each.
//!
//! Multiply-adds are `fma` if the compiler reports that it is fast, so results equal those of the library to one or two roundings; sines are those of
//! the C library.
//!
//! Long functions are split into parts, so the compile time is proportional to their length; parts exchange values in an array on the stack.
//!
//! CUDA kernels have the same statements for many states; a rollout has the loop over time in the kernel.
//!
//! # Compile time
//! Recording a step needs all of the physics over [`Traced`](crate::scalar::Traced), which is compiled with each program that calls
//! these functions. With the feature `graphs` it is compiled with the library: the first build takes longer, and later builds of the program do not
//! repeat it.
//!
//! # Choosing a target
//! * The library itself: needs no compiler, robots may change, all kinds of contact.
//! * A graph that is [interpreted](crate::scalar::Graph::evaluate_into): needs no compiler either. Use it for a derivative that the library lacks,
//!   such as a gradient in very many parameters. An operation takes some nanoseconds, ten times as long as in C.
//! * C: for other languages, for controllers on small computers, and for many evaluations of the same small robot. Functions of an arm take 0.34 to
//!   0.84 of the library's time, dynamics and step of a humanoid 0.82 to 0.95, its A and B 1.5 times that time; see
//!   [the table](crate::scalar::traced#size-and-speed). Trace again when the robot changes. The crate `dualbody-native` compiles and loads the code
//!   at run time.
//! * CUDA, for thousands of states of one robot or of variants: the crate `dualbody-cuda` does the same for GPUs.
//!
//! # Examples
//! ```
//! use dualbody::{Simulator, codegen::{self, Precision}, model::samples};
//!
//! let graph = codegen::step(&Simulator::new(samples::cartpole()));
//! let text = graph.to_c("cartpole_step", Precision::Double)?;
//! assert!(text.header.contains("#define CARTPOLE_STEP_IN_U 4"));
//! assert!(text.source.contains("int cartpole_step("));
//! # Ok::<(), dualbody::codegen::CodeError>(())
//! ```

mod adjoint;
mod c;
mod dynamics;
mod linearization;
mod origin;
mod ports;
mod step;

pub use adjoint::step_adjoint;
pub use c::{CodeError, CudaKernel, CudaSizes, CudaSource, Precision, RolloutInputs, Source};
pub use dynamics::{forward_dynamics, inverse_dynamics, inverse_dynamics_derivatives, mass_matrix};
pub use linearization::{linearization, linearization_of_variants};
pub use origin::{OtherRobot, check_origin};
pub use step::{feedback_step, step, step_of_variants};
