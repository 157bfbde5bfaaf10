//! Generated CUDA of [`dualbody`]: functions, steps and motions of thousands of states of a robot on a GPU.
//!
//! The crate records a computation of the library as a graph ([`dualbody::codegen`]) and writes it as kernels that compute one state per thread. NVRTC
//! compiles them to machine code, which is stored in a folder. The physics has no second copy. The crate builds without NVIDIA software: a program looks
//! for the driver (`libcuda`) and NVRTC (`libnvrtc`) at run time, and an error names a missing library.
//!
//! | question | function |
//! |---|---|
//! | many states of a robot, or of variants of it, with the interface of [`BatchSimulator`](dualbody::sim::BatchSimulator)? | [`CudaSimulator`]: steps, motions under given inputs or linear feedback, A and B, gradients |
//! | any graph for many states? | [`CudaFunction`]; for a step with the loop over time in the kernel, [`CudaStepper`] |
//! | inverse and forward dynamics, the step, A and B, gradients as graphs? | [`graphs`] |
//! | numbers that stay on the GPU between calls? | [`Numbers`], [`CudaStates`] |
//! | arrays shared with other libraries on the GPU, without a copy through the host? | `Numbers::into_dlpack`, `Numbers::copy_from_dlpack`, the same of `CudaStates`, with the feature `dlpack` |
//! | flags, folder of compiled kernels, compilation for machines without NVRTC? | [`Compiler`], which needs no GPU |
//! | time on the device? | [`Device::moment`] |
//!
//! Numbers are `f64` or `f32` ([`Real`]). Results are the same in every run, and equal those of the library to rounding. Every state has its own
//! [ending](Ending): a state whose motion diverges, or violates a condition of its graph, stops at its last valid value, and the others continue.
//!
//! # Examples
//! ```
//! use dualbody::{Simulator, State, model::samples};
//! use dualbody_cuda::{Compiler, CudaError, CudaSimulator, Device};
//!
//! let device = match Device::new(0) {
//!     Ok(device) => device,
//!     Err(error @ (CudaError::NoDriver { .. } | CudaError::NoDevice { .. })) => {
//!         println!("no GPU: {error}");
//!         return Ok(());
//!     }
//!     Err(error) => return Err(error),
//! };
//! let cartpole = Simulator::new(samples::cartpole()).with_time_step(0.01);
//! // Each state has its own damping of the pole, a parameter of its robot.
//! let names = ["pivot: damping"];
//! let damping: Vec<f64> = (0..1000).map(|i| 1e-4 * f64::from(i)).collect();
//! let gpu = CudaSimulator::<f32>::of_variants(cartpole, &names, &damping, 1000, &device, &Compiler::new())?;
//! let starts = vec![State::new(&[0.0, 0.3], &[0.0, 0.0]); 1000];
//! let motions = gpu.rollout_inputs(&starts, 500, 100, &vec![0.0; 1000 * 500 * 2])?;
//! assert_eq!(motions.steps(999), 500);
//! # Ok::<(), CudaError>(())
//! ```
//!
//! # Memory
//! Entry k of state i is at k × `count` + i, so neighbouring threads read neighbouring memory. Slices of one state after the other are transposed on
//! upload ([`Numbers::upload_states`]); arrays in the order of the device are copied as they are ([`Numbers::upload`]).
//!
//! A long function consists of several kernels. The values that they exchange, the inputs and the outputs need
//! [`work`](dualbody::codegen::CudaSizes::work) numbers for each state during the computation: 86 kB in `f64` for A and B of a humanoid. The device keeps
//! this workspace for the next call. [`Device::limit_workspace`] limits it; larger batches are computed in pieces.
//!
//! # Size of the kernels
//! Straight-line code grows with the robot. Values that do not fit into the 255 registers of a thread are stored in memory (*spilled*). The table was
//! measured by `benches/kernels/run.sh`, which needs no GPU, with NVRTC 12.9 for `sm_90`. Each cell has the values for `f64` and `f32`; times are
//! processor seconds; degrees of freedom are in brackets:
//!
//! | | operations | registers | spilled bytes, stores and loads | instructions | compilation, s |
//! |---|---|---|---|---|---|
//! | UR5 (6), inverse dynamics | 511 | 126, 71 | 0, 0 | 1,392, 1,464 | 0.2, 0.2 |
//! | motion under given inputs | 1,127 | 226, 122 | 0, 0 | 2,328, 2,304 | 0.3, 0.3 |
//! | gradients in state and input | 2,925 | 255, 255 | 6,748, 1,628 | 5,424, 4,744 | 0.8, 0.8 |
//! | A and B | 3,903 | 254, 255 | 1,948, 0 | 6,808, 6,064 | 1.4, 1.3 |
//! | Panda (8), inverse dynamics | 959 | 216, 110 | 0, 0 | 2,048, 2,096 | 0.2, 0.3 |
//! | motion under given inputs | 1,901 | 254, 128 | 0, 0 | 3,400, 3,280 | 0.6, 0.5 |
//! | gradients in state and input | 4,774 | 255, 255 | 16,476, 2,516 | 9,344, 7,376 | 1.6, 1.4 |
//! | A and B | 8,345 | 255, 255 | 19,908, 2,260 | 15,344, 13,160 | 4.6, 4.2 |
//! | quadruped (18), inverse dynamics | 1,530 | 255, 158 | 16, 0 | 3,584, 3,984 | 0.5, 0.6 |
//! | motion under given inputs | 3,060 | 255, 255 | 4,984, 0 | 6,560, 6,072 | 1.0, 1.2 |
//! | gradients in state and input | 9,563 | 255, 255 | 39,284, 11,640 | 20,344, 17,080 | 6.1, 5.2 |
//! | A and B | 23,216 | 255, 255 | 90,248, 9,344 | 48,536, 37,776 | 17, 13 |
//! | humanoid (35), inverse dynamics | 3,927 | 255, 255 | 3,952, 240 | 8,992, 9,472 | 2.3, 3.5 |
//! | gradients in state and input | 30,510 | 255, 255 | 98,592, 23,188 | 67,240, 58,960 | 18, 21 |
//! | A and B | 90,698 | 255, 255 | 434,800, 63,772 | 192,272, 152,576 | 71, 61 |
//!
//! Inverse dynamics and motions of arms fit into registers in both precisions, those of a quadruped in `f32`; derivatives do not. A function of up to
//! 10,000 operations is one kernel. A longer one is cut into parts of 2,000 operations, each a kernel, which are compiled in parallel; the table has
//! the largest number of registers of a part, and sums otherwise. A step is one kernel of any length, with functions of up to 10,000 operations in it.
//! Compiled kernels are stored on disk, and can be copied to machines without NVRTC ([`Compiler::precompile`]).
//!
//! Kernels that loop over a table of bodies would have constant size, and another robot would need no compilation. The crate does not have them: a loop
//! would store all values of all bodies in memory, and look up axes and placements that are constants in straight-line code. If compilation is not
//! possible, use the loops of the library on the CPU.
//!
//! # Speed
//! States or steps a second on an NVIDIA H200 (driver 580.159.04); each cell has the values for `f64` and `f32`:
//!
//! | | inverse dynamics | forward dynamics | step | step, 100 in a call | A and B | gradients |
//! |---|---|---|---|---|---|---|
//! | UR5 (6) | 10.4 G, 20.2 G | 4.50 G, 9.80 G | 6.32 G, 12.9 G | 7.87 G, 17.9 G | 923 M, 1.68 G | 755 M, 2.66 G |
//! | Panda (8) | 4.78 G, 11.1 G | 3.83 G, 8.18 G | 4.41 G, 8.33 G | 5.09 G, 10.2 G | 154 M, 295 M | 260 M, 1.61 G |
//! | quadruped (18) | 2.45 G, 4.89 G | 1.47 G, 2.54 G | 1.34 G, 3.89 G | 1.45 G, 4.73 G | 16.4 M, 29.7 M | 106 M, 205 M |
//! | humanoid (35) | 493 M, 914 M | 213 M, 327 M | 127 M, 283 M | 116 M, 319 M | 3.58 M, 6.36 M | 19.6 M, 42.8 M |
//! | quadruped on four feet, soft contact | – | – | 617 M, 2.68 G | 834 M, 3.49 G | 8.34 M, 14.6 M | 53.1 M, 115 M |
//! | humanoid on both feet (eight points), soft contact | – | – | 124 M, 230 M | 112 M, 256 M | 2.14 M, 4.02 M | 16.8 M, 35.0 M |
//! | quadruped on four feet, regularised contact | – | – | 28.2 M, – | 25.0 M, – | – | – |
//!
//! Batches have 1,048,576 states, or as many as fit into 16 GiB. An arm needs 262,144 states for such rates, a humanoid 16,384 to 65,536.
//! `benches/RESULTS.md` has the command, the errors, and the share of the arithmetic and memory traffic of the card: steps of arms use half of its
//! arithmetic, derivatives of more than 10,000 operations 2 to 5 %.
//!
//! # Safety
//! All unsafe code is in `nvrtc.rs` and `driver.rs` (calls of these libraries), `launcher.rs` (starts of kernels: this crate has written their text and
//! checked the lengths of their arrays) and `tensor.rs` (tensors of `DLPack`). Anyone with write access to the folder of compiled kernels can change
//! the code that runs on the GPU.

#![deny(unsafe_code)]

mod architecture;
mod compiler;
mod derivatives;
mod device;
#[cfg(feature = "dlpack")]
mod dlpack;
mod driver;
mod error;
mod feedback;
mod function;
pub mod graphs;
mod kernel;
mod launcher;
mod moment;
mod numbers;
mod nvrtc;
mod ranges;
mod real;
mod rollout;
mod simulator;
mod states;
mod stepper;
#[cfg(feature = "dlpack")]
mod tensor;
mod workspace;

pub use architecture::Architecture;
pub use compiler::{Compiled, Compiler};
pub use derivatives::Gradients;
pub use device::Device;
#[cfg(feature = "dlpack")]
pub use dlpack::check_dlpack;
pub use error::CudaError;
pub use feedback::LinearFeedback;
pub use function::{CudaFunction, Outputs};
pub use moment::Moment;
pub use numbers::{Numbers, Status};
pub use real::Real;
pub use rollout::CudaRollout;
pub use simulator::CudaSimulator;
pub use states::{CudaStates, Ending};
pub use stepper::{CudaStepper, Schedule, StepInputs};
#[cfg(feature = "dlpack")]
pub use tensor::{Dlpack, dlpack_of};
