//! Activations of inputs.

use dualbody::sim::{Activation, ActuatorNetwork};

use crate::prelude::*;

/// The simulator with the activations that its parts name.
pub(super) fn add(mut simulator: Simulator, parts: &Bound<'_, PyAny>) -> PyResult<Simulator> {
    let given = parts.get_item("activations")?;
    if given.is_none() {
        return Ok(simulator);
    }
    for (input, value) in given.cast::<PyDict>()? {
        let input: String = input.extract()?;
        check_kind(
            format_args!("activations[\"{input}\"]"),
            &value,
            "sim",
            &["Activation"],
            "",
        )?;
        let own = activation_of(&value)?;
        simulator = simulator.with_activation(&input, own).or_raise()?;
    }
    Ok(simulator)
}

fn activation_of(value: &Bound<'_, PyAny>) -> PyResult<Activation> {
    let dynamics = value.getattr("dynamics")?;
    let time: Option<f64> = attribute(value, "time_constant")?;
    let mut own = match dynamics.extract::<String>().ok().as_deref() {
        None => {
            let hint = " (or \"none\", \"filter\", \"explicit_filter\", \"integrator\")";
            check_kind("dynamics", &dynamics, "sim", &["ActuatorNetwork"], hint)?;
            let network = network_of(&dynamics)?;
            Activation::function(network, &[])
        }
        Some("none") => Activation::delay(0),
        Some("integrator") => Activation::integrator(),
        Some(kind @ ("filter" | "explicit_filter")) => {
            let missing = || invalid!("a {kind} has no time_constant");
            let time = time.ok_or_else(missing)?;
            guarded(|| match kind {
                "filter" => Activation::filter(time),
                _ => Activation::explicit_filter(time),
            })?
        }
        Some(other) => {
            refuse!(
                "dynamics is \"{other}\", not \"none\", \"filter\", \"explicit_filter\", \"integrator\" or an ActuatorNetwork"
            );
        }
    };
    let delay: usize = attribute(value, "delay")?;
    own = own.with_delay(delay);
    if let Some((lower, upper)) = attribute(value, "input_range")? {
        own = own.with_input_range(lower, upper);
    }
    if let Some((lower, upper)) = attribute(value, "range")? {
        own = own.with_range(lower, upper);
    }
    Ok(if attribute(value, "early")? {
        own.early()
    } else {
        own
    })
}

fn network_of(value: &Bound<'_, PyAny>) -> PyResult<ActuatorNetwork> {
    let mut layers = Vec::new();
    for layer in value.getattr("layers")?.try_iter()? {
        let (weights, offsets): (Bound<'_, PyAny>, Bound<'_, PyAny>) = layer?.extract()?;
        let offsets = read_vector("offsets of a layer", &offsets, None)?;
        let mut numbers = Vec::new();
        for row in weights.try_iter()? {
            numbers.extend(read_vector("a row of weights", &row?, None)?);
        }
        let rows = offsets.len();
        if rows == 0 || numbers.len() % rows != 0 {
            refuse!(
                "a layer has {} weights in {rows} rows of offsets",
                numbers.len()
            );
        }
        layers.push((
            DMatrix::from_row_slice(rows, numbers.len() / rows, &numbers),
            offsets,
        ));
    }
    let ages: Vec<usize> = attribute(value, "ages")?;
    guarded(|| ActuatorNetwork::new(layers, &ages))
}
