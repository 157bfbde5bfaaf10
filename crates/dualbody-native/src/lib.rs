//! Generated C of [`dualbody`], compiled and loaded while a program runs.
//!
//! Straight-line code with the parameters of one robot can be faster than loops over its bodies. [`dualbody::codegen`] traces a function and writes
//! it as C. This crate passes the C code to the system's compiler, stores the result in a folder, and loads it.
//!
//! | question | function | cost |
//! |---|---|---|
//! | a graph as a function of this program? | [`NativeFunction`], in double or single precision | compilation: 0.3 to 12 s for robots of up to 18 degrees of freedom; then a stored file |
//! | a simulator whose steps are compiled? | [`NativeSimulator`]: steps, Jacobians, rollouts, many states, a system of `dualbody::trajopt` | the same |
//! | compiler, flags, folder? | [`Compiler`] | |
//! | stop a compiler that takes too long? | a [`StopSignal`](dualbody::StopSignal), if the compiler is started within its [`watch`](dualbody::StopSignal::watch) | |
//!
//! Without a compiler, [`NativeSimulator::or_own`] uses the library's own code, and [`NativeSimulator::reason`] explains why. The section
//! "Choosing a target" of [`dualbody::codegen`] states when compilation is worthwhile.
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
//! Loaded code runs with the rights of the program. It is compiled from text that this crate has written, and stored in a folder of the user
//! ([`Compiler::with_cache`]). Anyone with write access to that folder can change the program. All unsafe code is in `loaded.rs`.

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
