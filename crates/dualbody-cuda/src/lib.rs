//! Generated CUDA of [`dualbody`]: functions, steps and motions of thousands of states of a robot on a GPU.
//!
//! What the library computes is recorded as a graph ([`dualbody::codegen`]), written as kernels that compute a state a thread, compiled by NVRTC to machine code, which
//! is kept in a folder, and run. There is no second copy of the physics. Nothing is needed to build this crate; the driver (`libcuda`) and NVRTC (`libnvrtc`) are looked for when a
//! program runs, and where one is missing an error says what was looked for.
//!
//! | question | function |
//! |---|---|
//! | many states of a robot, or of variants of it, as [`BatchSimulator`](dualbody::sim::BatchSimulator) steps them? | [`CudaSimulator`]: steps, motions under given inputs or linear feedback, A and B, gradients |
//! | any graph for many states? | [`CudaFunction`]; of a step, with the loop over time in the kernel, [`CudaStepper`] |
//! | inverse and forward dynamics, the step, A and B, gradients as graphs? | [`graphs`] |
//! | numbers that stay on the GPU between calls? | [`Numbers`], [`CudaStates`] |
//! | numbers of other libraries on the GPU, without a way over the host? | `Numbers::into_dlpack`, `Numbers::copy_from_dlpack`, with the feature `dlpack` |
//! | what is compiled, with which flags, kept where? | [`Compiler`], which needs no GPU |
//!
//! Numbers are `f64` or `f32` ([`Real`]); results are the same on every run, and those of the library to rounding. Every state has its own [ending](Ending): one whose motion diverges, or leaves a
//! condition of its graph, stops at its last right state, and the others go on.
//!
//! # Examples
//! ```
//! use dualbody::{Simulator, State, model::samples};
//! use dualbody_cuda::{Compiler, CudaError, CudaSimulator, Device};
//!
//! let device = match Device::new(0) {
//!     Ok(device) => device,
//!     Err(error @ (CudaError::NoDriver { .. } | CudaError::NoDevice { .. })) => {
//!         println!("no GPU here: {error}");
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
//! Number k of state i stands at k × `count` + i, so that threads side by side read memory side by side. Slices of one state after the other are turned round on the way to the
//! device ([`Numbers::upload_states`]); who has them in that order already saves that ([`Numbers::upload`]).
//! What the kernels of a long function hand to each other, its inputs and its outputs need [`work`](dualbody::codegen::CudaSizes::work) numbers for each state while it is computed: 8 kB in `f64` for A and B of a
//! Panda.
//!
//! # How large it gets
//! Straight-line code grows with the robot, and what does not fit into the 255 registers of a thread waits in memory (*spilled*). As `benches/kernels/run.sh` counts it, which needs no GPU, with
//! NVRTC 12.9 for `sm_90`; each cell says `f64`, `f32`, times are processor seconds, degrees of freedom stand in brackets:
//!
//! | | operations | registers | spilled bytes, stored and loaded | instructions | compiled in, s |
//! |---|---|---|---|---|---|
//! | UR5 (6), inverse dynamics | 511 | 126, 71 | 0, 0 | 1,392, 1,464 | 0.4, 0.5 |
//! | motion under given inputs | 1,127 | 226, 122 | 0, 0 | 2,328, 2,304 | 0.7, 0.8 |
//! | gradients in state and input | 2,925 | 255, 255 | 4,144, 512 | 5,760, 5,648 | 2.2, 2.5 |
//! | A and B | 3,903 | 254, 203 | 1,600, 0 | 6,328, 5,824 | 2.7, 2.2 |
//! | Panda (8), inverse dynamics | 959 | 216, 110 | 0, 0 | 2,048, 2,096 | 0.6, 0.6 |
//! | motion under given inputs | 1,901 | 254, 128 | 0, 0 | 3,400, 3,280 | 1.1, 1.2 |
//! | gradients in state and input | 4,774 | 255, 255 | 8,832, 392 | 9,200, 7,592 | 3.5, 3.3 |
//! | A and B | 8,345 | 255, 255 | 13,936, 184 | 14,568, 12,272 | 6.9, 5.9 |
//! | quadruped (18), inverse dynamics | 1,530 | 255, 157 | 104, 0 | 3,568, 3,936 | 1.1, 1.4 |
//! | motion under given inputs | 3,060 | 255, 210 | 1,336, 0 | 7,288, 6,936 | 2.3, 2.7 |
//! | one step | 3,060 | 255, 164 | 32, 0 | 6,672, 6,568 | 1.9, 2.0 |
//! | gradients in state and input | 9,563 | 255, 255 | 32,000, 7,336 | 23,416, 19,528 | 13, 14 |
//! | A and B | 23,216 | 255, 255 | 90,112, 9,344 | 48,808, 38,056 | 26, 21 |
//! | humanoid (35), inverse dynamics | 3,927 | 255, 255 | 3,240, 216 | 9,544, 9,984 | 2.7, 2.9 |
//! | motion under given inputs | 8,912 | 255, 255 | 4,080, 352 | 18,968, 17,784 | 6.9, 6.9 |
//! | one step | 8,912 | 255, 168 | 1,248, 0 | 17,592, 19,928 | 5.6, 7.0 |
//! | gradients in state and input | 30,510 | 255, 255 | 98,148, 23,188 | 67,984, 59,752 | 33, 32 |
//! | A and B | 90,698 | 255, 255 | 434,800, 63,772 | 192,680, 153,008 | 113, 97 |
//!
//! So inverse dynamics and motions of arms fit into registers in both precisions, those of a quadruped in `f32`; derivatives do not, and the largest need 40 times as much memory for each state as there are
//! registers. Functions of up to 10,000 operations are one kernel, longer ones are cut into parts of 2,000, each of which is a kernel; all are compiled at once, on all cores. Registers are the most of one of
//! these, the rest is their sum. Steps are one kernel however long they are, with functions of up to 10,000 operations in it. What is compiled is kept on disk, and may be carried to
//! machines without NVRTC ([`Compiler::precompile`]).
//!
//! Kernels that loop over a table of the bodies, with the work at each kind of joint recorded once, would be of constant size and need no compiling for another robot. They are not here: a loop
//! would keep all numbers of all bodies in that same memory, and look up axes and placements that are constants here. Where nothing may be compiled, the library's own loops serve.
//!
//! # How fast it is
//! States or steps a second on an NVIDIA H200 (driver 580.159.04); each cell says `f64`, `f32`:
//!
//! @@RATES@@
//!
//! Batches are of 1,048,576 states, or of what fits into 16 GiB; from 262,144 states on, rates of an arm are those of the table, from 65,536 those of a humanoid. `benches/RESULTS.md` has the command, the errors, and which share
//! of the card's arithmetic and memory traffic these are: half of it for steps of arms, 2 to 9 % for the longest derivatives.
//!
//! # Safety
//! All unsafe code is in `launcher.rs` and the module in it: calls of NVRTC, tensors of `DLPack`, and starts of kernels, whose text this crate has made and whose arrays it has measured. Whoever may write to the folder of
//! compiled kernels may change what runs on the GPU.

#![deny(unsafe_code)]

mod architecture;
mod compiler;
mod derivatives;
mod device;
#[cfg(feature = "dlpack")]
mod dlpack;
mod error;
mod feedback;
mod function;
pub mod graphs;
mod kernel;
mod launcher;
mod moment;
mod numbers;
mod ranges;
mod real;
mod rollout;
mod simulator;
mod states;
mod stepper;
mod workspace;

pub use architecture::Architecture;
pub use compiler::{Compiled, Compiler};
pub use derivatives::Gradients;
pub use device::Device;
#[cfg(feature = "dlpack")]
pub use dlpack::{Dlpack, check_dlpack};
pub use error::CudaError;
pub use feedback::LinearFeedback;
pub use function::{CudaFunction, Outputs};
#[cfg(feature = "dlpack")]
pub use launcher::dlpack::dlpack_of;
pub use moment::Moment;
pub use numbers::{Numbers, Status};
pub use real::Real;
pub use rollout::CudaRollout;
pub use simulator::CudaSimulator;
pub use states::{CudaStates, Ending};
pub use stepper::{CudaStepper, Schedule, StepInputs};
