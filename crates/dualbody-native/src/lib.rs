//! Generated C of [`dualbody`], compiled and loaded while a program runs.
//!
//! A function of a robot that is computed very often takes less time as straight-line code with the robot's parameters than as loops over its
//! bodies: [`dualbody::codegen`] traces it and writes C, this crate passes it to the system's compiler, keeps the result in a folder, and loads it.
//!
//! | question | function |
//! |---|---|
//! | a graph as a function of this program? | [`NativeFunction`], in double or single precision |
//! | a simulator whose steps are compiled? | [`NativeSimulator`]: steps, Jacobians, rollouts, many states, a system of `dualbody::trajopt` |
//! | which compiler, which flags, kept where? | [`Compiler`] |
//! | end a compiler that takes too long? | a [`StopSignal`](dualbody::StopSignal) within whose [`watch`](dualbody::StopSignal::watch) it is started |
//!
//! Without a compiler, [`NativeSimulator::or_own`] computes by the library's own code, and has the reason. When to compile and when not:
//! [`dualbody::codegen`], "Choosing a target".
//!
//! # Examples
//! ```
//! use dualbody::{Simulator, State, model::samples};
//! use dualbody_native::{Compiler, NativeSimulator};
//!
//! let simulator = Simulator::new(samples::pendulum()).with_time_step(0.01);
//! let native = NativeSimulator::or_own(simulator.clone(), &Compiler::default());
//! if let Some(reason) = native.reason() {
//!     println!("not compiled: {reason}");
//! }
//! let start = State::new(&[0.3], &[0.0]);
//! let (swing, own) = (native.rollout(&start, 100, |_, _, _| {}), simulator.rollout(&start, 100, |_, _, _| {}));
//! assert!((swing.last().q[0] - own.last().q[0]).abs() < 1e-12);
//! ```
//!
//! # Safety
//! Loaded code runs with the rights of the program. It is compiled from text that this crate has made, and kept in a folder of the user's own
//! ([`Compiler::with_cache`]); anyone who may write to that folder can change the program. All unsafe code is in `loaded.rs`.

#![deny(unsafe_code)]

mod compiler;
mod error;
mod function;
mod loaded;
mod numbers;
mod process;
mod real;
mod simulator;
mod system;

pub use compiler::Compiler;
pub use error::NativeError;
pub use function::NativeFunction;
pub use real::Real;
pub use simulator::{NativeScratch, NativeSimulator};
