//! Code made of a robot: its dynamics and its step as expression graphs, as C, and as CUDA.
//!
//! The functions here record the library's computations as expression graphs. [`trace`](crate::scalar::traced::trace) records any other computation.
//! [`scalar::traced`](crate::scalar::traced) lists what can be traced, sizes and times.
//!
//! | question | function | cost | source |
//! |---|---|---|---|
//! | joint forces, accelerations, M as a graph? | [`inverse_dynamics`], [`forward_dynamics`], [`mass_matrix`] | below 3 ms to record, for up to 35 degrees of freedom | [Griewank, Walther 2008] |
//! | derivatives of joint forces? | [`inverse_dynamics_derivatives`] | some milliseconds | the same |
//! | a step, with A and B? | [`step`], [`linearization`] | 1 to 7 ms, 4 to 82 ms | the same |
//! | the same of variants of a robot, with parameters as inputs? | [`step_of_variants`], [`linearization_of_variants`] | the same | |
//! | a step under linear feedback, the gradient of a step? | [`feedback_step`], [`step_adjoint`] | some times the step | the same, chapter 3 |
//! | as C? | [`Graph::to_c`](crate::scalar::Graph::to_c) | linear in the graph | |
//! | as CUDA, for thousands of states? | [`Graph::to_cuda`](crate::scalar::Graph::to_cuda), [`Graph::to_cuda_rollout`](crate::scalar::Graph::to_cuda_rollout) | linear in the graph | |
//! | was it recorded from this robot? | [`check_origin`] | O(n) | |
//!
//! # The text
//! C99 without dependencies but `math.h`, without allocation, for microcontrollers and other languages:
//!
//! * `int NAME(const NAME_real *in, NAME_real *out)` – all inputs one after the other in one array, all outputs in
//!   another; the header says where each begins. It returns 0, or the number, from 1, of the first
//!   [condition](crate::scalar::Graph::conditions) that does not hold.
//! * `size_t NAME_batch(size_t count, const NAME_real *in, NAME_real *out, int *status)` – for one state after the
//!   other, the inputs of each contiguous.
//!
//! Products with a sum are `fma` where the compiler says that it is fast, so that results are those of the library to
//! the last rounding or two, and sines are those of the C library.
//!
//! Long functions are split into parts, which compilers take in time proportional to their length; numbers that one
//! part hands to another wait in an array on the stack.
//!
//! Kernels in CUDA have the same statements, on numbers of many states side by side; a rollout has the loop over time in the kernel.
//!
//! # What it costs to build
//! Recording a step takes all of the physics over [`Traced`](crate::scalar::Traced), which is compiled with each program that calls these functions. With the
//! feature `graphs` it is compiled with the library: the first build takes longer, and a changed line in the program costs nothing of it.
//!
//! # Choosing a target
//! * The library itself, where it runs: no compiler is needed, robots may change, contact may be of any kind.
//! * A graph that is [interpreted](crate::scalar::Graph::evaluate_into), without a compiler, for a
//!   derivative that the library lacks, such as a gradient in very many parameters: an instruction takes
//!   some nanoseconds, ten times what it takes in C.
//! * C, for other languages, for controllers on small computers, and where the same small robot is computed over and
//!   over: an arm's functions take a third to nine tenths of the library's time, a humanoid's dynamics and step little less,
//!   its A and B half as long again, as [the table](crate::scalar::traced#how-large-it-gets) says. Trace once more
//!   when the robot changes. The crate `dualbody-native`, beside this one, compiles and loads the text while a program runs.
//! * CUDA, for thousands of states of one robot, or of variants of it: the crate `dualbody-cuda` does the same for GPUs.
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
pub use origin::{OtherRobot, check_made_of, check_origin};
pub use step::{feedback_step, step, step_of_variants};
