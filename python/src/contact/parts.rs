//! Constraints, forces and inputs at places.

use dualbody::constraint::{Anchor, Constraint};
use dualbody::sim::{ExternalForce, FrameActuator, TendonServo};
use dualbody::spatial::{Force, Representation};
use dualbody::{Model, Simulator};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::motors::servo_of;
use crate::dynamics::named;
use crate::errors::{OrRaise, guarded};
use crate::kinds::{check_kind, kind_of};
use crate::model::read_pose;

fn anchor_of(model: &Model, name: &str, of: &Bound<'_, PyAny>) -> PyResult<Anchor> {
    let value = of.getattr(name)?;
    check_kind(name, &value, "sim", &["Anchor"], ", as Anchor(\"link\")")?;
    let frame: Option<String> = value.getattr("frame")?.extract()?;
    let placement = read_pose("placement", &value.getattr("placement")?)?;
    let frame = frame
        .map(|name| model.find_frame(&name).or_raise())
        .transpose()?;
    guarded(|| Anchor::new(frame, placement))
}

fn constraint_of(model: &Model, value: &Bound<'_, PyAny>) -> PyResult<Constraint> {
    let kind = kind_of(value)?;
    let anchors = || -> PyResult<[Anchor; 2]> {
        Ok([anchor_of(model, "a", value)?, anchor_of(model, "b", value)?])
    };
    let number = |name: &str| -> PyResult<f64> { value.getattr(name)?.extract() };
    let constraint = match kind.as_str() {
        "Weld" => Constraint::weld(anchors()?),
        "Ball" => Constraint::ball(anchors()?),
        "Distance" => {
            let (anchors, length) = (anchors()?, number("length")?);
            Constraint::distance(anchors, length)
        }
        "Tendon" => {
            let joints = coefficients_of(value)?;
            let joints: Vec<(&str, f64)> = joints.iter().map(|(name, c)| (&**name, *c)).collect();
            let length = number("length")?;
            Constraint::tendon(model, &joints, length).or_raise()?
        }
        _ => {
            let (one, other): (String, String) = value.getattr("joints")?.extract()?;
            let (ratio, offset) = (number("ratio")?, number("offset")?);
            Constraint::coupler(model, [&one, &other], ratio, offset).or_raise()?
        }
    };
    let given = |name: &str| value.getattr(name);
    let time: Option<f64> = given("time_constant")?.extract()?;
    let spring: Option<(f64, f64)> = given("spring")?.extract()?;
    let bound: Option<f64> = given("largest_force")?.extract()?;
    if time.is_some() && spring.is_some() {
        let text = "a constraint has a time_constant or a spring, not both";
        return Err(PyValueError::new_err(text));
    }
    guarded(|| {
        let timed = time.map(|time| constraint.clone().with_time_constant(time));
        let sprung = spring.map(|(k, d)| constraint.clone().with_spring(k, d));
        let held = timed.or(sprung).unwrap_or(constraint);
        match bound {
            Some(bound) => held.with_largest_force(bound),
            None => held,
        }
    })
}

fn force_of(x: [f64; 6]) -> Force<f64> {
    Force::from_array(x)
}

/// A list of parts of some classes.
fn list<'py, T>(
    parts: &Bound<'py, PyAny>,
    name: &str,
    classes: &[&str],
    one: impl Fn(&Bound<'py, PyAny>) -> PyResult<T>,
) -> PyResult<Vec<T>> {
    let all: Vec<Bound<'_, PyAny>> = parts.get_item(name)?.extract()?;
    for (k, one) in all.iter().enumerate() {
        check_kind(format_args!("{name}[{k}]"), one, "sim", classes, "")?;
    }
    all.iter().map(one).collect()
}

/// Coefficients of joints by name.
fn coefficients_of(value: &Bound<'_, PyAny>) -> PyResult<Vec<(String, f64)>> {
    let joints = value.getattr("joints")?.call_method0("items")?;
    joints.try_iter()?.map(|item| item?.extract()).collect()
}

fn external_force_of(model: &Model, value: &Bound<'_, PyAny>) -> PyResult<ExternalForce> {
    let place = anchor_of(model, "place", value)?;
    let (force, name): ([f64; 6], String) = (
        value.getattr("force")?.extract()?,
        value.getattr("representation")?.extract()?,
    );
    let representation = named::<Representation>(model, &name)?;
    guarded(|| ExternalForce::constant(place, force_of(force), representation))
}

/// Adds to a simulator what its description in Python names, besides contacts.
pub(crate) fn with_parts(
    mut simulator: Simulator,
    parts: &Bound<'_, PyAny>,
) -> PyResult<Simulator> {
    let model = simulator.model().clone();
    let kinds = ["Weld", "Ball", "Distance", "Coupler", "Tendon"];
    let all = list(parts, "constraints", &kinds, |c| constraint_of(&model, c))?;
    if !all.is_empty() {
        let all = [simulator.constraints(), &all].concat();
        simulator = simulator.with_constraints(all);
    }
    let all = list(parts, "external_forces", &["ExternalForce"], |f| {
        external_force_of(&model, f)
    })?;
    if !all.is_empty() {
        simulator = simulator.with_external_forces(all);
    }
    let all = list(parts, "frame_actuators", &["FrameActuator"], |a| {
        frame_actuator_of(&model, a)
    })?;
    if !all.is_empty() {
        let all = [simulator.frame_actuators(), &all].concat();
        simulator = simulator.with_frame_actuators(all);
    }
    let all = list(parts, "tendon_servos", &["TendonServo"], |t| {
        tendon_servo_of(&model, t)
    })?;
    if !all.is_empty() {
        let all = [simulator.tendon_servos(), &all].concat();
        simulator = simulator.with_tendon_servos(all);
    }
    let simulator = super::sleeping::add(simulator, parts)?;
    super::activations::add(simulator, parts)
}

fn tendon_servo_of(model: &Model, value: &Bound<'_, PyAny>) -> PyResult<TendonServo> {
    let name: String = value.getattr("name")?.extract()?;
    let joints = coefficients_of(value)?;
    let joints: Vec<(&str, f64)> = joints.iter().map(|(name, c)| (&**name, *c)).collect();
    let missing = || PyValueError::new_err(format!("the tendon \"{name}\" has no servo"));
    let servo = servo_of(value)?.ok_or_else(missing)?;
    let made = TendonServo::new(model, name.clone(), &joints, servo).or_raise()?;
    match value.getattr("effort")?.extract()? {
        Some(effort) => guarded(|| made.with_effort(effort)),
        None => Ok(made),
    }
}

fn frame_actuator_of(model: &Model, value: &Bound<'_, PyAny>) -> PyResult<FrameActuator> {
    let name: String = value.getattr("name")?.extract()?;
    let place = anchor_of(model, "place", value)?;
    let (wrench, axes): ([f64; 6], String) = (
        value.getattr("wrench")?.extract()?,
        value.getattr("representation")?.extract()?,
    );
    let representation = named::<Representation>(model, &axes)?;
    let limits: Option<(f64, f64)> = value.getattr("limits")?.extract()?;
    let servo = servo_of(value)?;
    guarded(|| {
        let actuator = FrameActuator::new(name, place, force_of(wrench), representation);
        let actuator = match servo {
            Some(servo) => actuator.with_servo(servo),
            None => actuator,
        };
        match limits {
            Some((lower, upper)) => actuator.with_limits(lower, upper),
            None => actuator,
        }
    })
}
