//! Calls of compiled programs.

use super::frame::Frame;
use super::registry::{Used, find};
use crate::calls::{Call, Of};
use crate::prelude::*;

/// Makes the call that a frame describes.
pub(super) fn call(frame: &Frame<'_>) -> Result<(), String> {
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
