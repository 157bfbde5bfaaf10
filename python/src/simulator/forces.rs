//! Forces on frames by name, in a step or at a moment.

use crate::prelude::*;

/// A simulator with an input for each coordinate of the forces, and the input with them.
pub(super) fn with_forces<'py>(
    this: &Bound<'py, PySimulator>,
    u: Option<&Bound<'py, PyAny>>,
    forces: &Bound<'py, PyAny>,
    representation: &str,
    has_models: bool,
) -> PyResult<(Bound<'py, PySimulator>, Option<Bound<'py, PyAny>>)> {
    if has_models {
        refuse!("forces act on states of one robot: give forces or models, not both");
    }
    let py = this.py();
    let parts = this.get().parts.bind(py).as_any();
    let actuators = parts.get_item("frame_actuators")?;
    let forced = of_package!(py, "_forces", "_forced");
    let made = forced.call1((this, actuators, u, forces, representation))?;
    made.extract()
}
