//! The library behind JAX's foreign-function interface: what compiled programs of JAX call on the CPU, without the interpreter.
//!
//! | file | what it is |
//! |---|---|
//! | `abi` | the structs of XLA's interface for foreign functions, as far as they are read here |
//! | `frame` | one call: arrays of arguments and results, attributes |
//! | `registry` | robots and simulators by a digest of what they are, which compiled programs name them by |
//!
//! A call names its function and its robot in attributes. Programs outlive the objects of Python that they were traced with, even in files between
//! processes, so a robot is named by what it is, and kept.

mod abi;
mod frame;
mod registry;

use std::ffi::c_void;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr::null_mut;

use pyo3::types::PyCapsule;

use abi::CallFrame;
use frame::Frame;

use crate::calls::{Call, Of};
use crate::prelude::*;
pub(crate) use registry::_foreign_name;
use registry::{Used, find};

/// Makes the call that a frame describes.
fn call(frame: &Frame<'_>) -> Result<(), String> {
    let of = match find(frame.text("of")?)? {
        Used::Model(model) => Of::Model(model.get()),
        Used::Simulator(simulator) => Of::Simulator(simulator.get()),
    };
    let text = frame.text("call")?;
    let arguments = frame.arguments()?;
    let numbers: Vec<&[f64]> = arguments.iter().map(|x| &**x).collect();
    let run = |out: &mut [&mut [f64]]| {
        let done = caught(|| Call::read(of, text)?.run(&numbers, out));
        // The text without the name of the exception.
        done.map_err(|error| Python::attach(|py| error.value(py).to_string()))
    };
    frame.fill(run)
}

/// The function that XLA calls.
///
/// # Safety
/// XLA calls it with a frame of the layout of `abi`, whose arrays stay while it runs.
unsafe extern "C" fn handler(frame: *mut CallFrame) -> *mut c_void {
    // SAFETY: as promised by the caller.
    let Some(frame) = (unsafe { Frame::open(frame) }) else {
        return null_mut();
    };
    // Nothing may unwind into XLA.
    let done = catch_unwind(AssertUnwindSafe(|| call(&frame)));
    match done {
        Ok(Ok(())) => null_mut(),
        Ok(Err(text)) => frame.error(&text),
        Err(_) => frame.error("the library panicked"),
    }
}

/// The function that XLA calls, as a capsule for `jax.ffi.register_ffi_target`.
#[pyfunction]
pub(crate) fn _foreign_function(py: Python<'_>) -> PyResult<Bound<'_, PyCapsule>> {
    let function = handler as unsafe extern "C" fn(*mut CallFrame) -> *mut c_void as *mut c_void;
    // SAFETY: a function has no end, and the capsule's name is none, as JAX expects.
    unsafe {
        Bound::from_owned_ptr_or_err(
            py,
            pyo3::ffi::PyCapsule_New(function, std::ptr::null(), None),
        )?
        .cast_into::<PyCapsule>()
        .map_err(Into::into)
    }
}
