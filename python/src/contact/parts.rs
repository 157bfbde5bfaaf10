//! Constraints, forces and inputs at places.

use dualbody::constraint::{Anchor, Constraint, Regularisation};
use dualbody::sim::{ExternalForce, FrameActuator, Sleeping, TendonServo};
use dualbody::spatial::{Force, Representation};

use super::law::{impedance_of, reference_of};
use super::motors::servo_of;
use crate::dynamics::named;
use crate::model::read_pose;
use crate::prelude::*;

fn anchor_of(model: &Model, name: &str, of: &Bound<'_, PyAny>) -> PyResult<Anchor> {
    let value = of.getattr(name)?;
    check_kind(name, &value, "sim", &["Anchor"], ", as Anchor(\"link\")")?;
    let frame: Option<String> = attribute(&value, "frame")?;
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
    let number = |name| attribute::<f64>(value, name);
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
            let (one, other): (String, String) = attribute(value, "joints")?;
            let (c0, c1) = (number("offset")?, number("ratio")?);
            let higher: Vec<f64> = attribute(value, "higher")?;
            ensure!(
                higher.len() <= 3,
                "higher has {} numbers, at most those of the powers 2, 3 and 4",
                higher.len()
            );
            let power = |k: usize| higher.get(k).copied().unwrap_or(0.0);
            let polynomial = [c0, c1, power(0), power(1), power(2)];
            guarded(|| Constraint::polynomial_coupler(model, [&one, &other], polynomial))?
                .or_raise()?
        }
    };
    let time: Option<f64> = attribute(value, "time_constant")?;
    let spring: Option<(f64, f64)> = attribute(value, "spring")?;
    let bound: Option<f64> = attribute(value, "largest_force")?;
    let soft = regularisation_of(value)?;
    let laws = [time.is_some(), spring.is_some(), soft.is_some()];
    if laws.into_iter().filter(|is_given| *is_given).count() > 1 {
        refuse!("a constraint has one of time_constant, spring and regularisation, not several");
    }
    guarded(|| {
        let timed = time.map(|time| constraint.clone().with_time_constant(time));
        let sprung = spring.map(|(k, d)| constraint.clone().with_spring(k, d));
        let soft = soft.map(|soft| constraint.clone().with_regularisation(soft));
        let held = timed.or(sprung).or(soft).unwrap_or(constraint);
        match bound {
            Some(bound) => held.with_largest_force(bound),
            None => held,
        }
    })
}

/// The regularisation of a constraint, if it has one.
fn regularisation_of(constraint: &Bound<'_, PyAny>) -> PyResult<Option<Regularisation>> {
    let value = constraint.getattr("regularisation")?;
    if value.is_none() {
        return Ok(None);
    }
    check_kind("regularisation", &value, "sim", &["Regularisation"], "")?;
    let (reference, impedance) = (reference_of(&value)?, impedance_of(&value)?);
    let own = fields!(value => Regularisation { reference: reference, impedance: impedance, inverse_mass, inverse_inertia, lever });
    Ok(Some(own))
}

fn force_of(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Force<f64>> {
    attribute(value, name).map(Force::from_array)
}

fn axes_of(model: &Model, value: &Bound<'_, PyAny>) -> PyResult<Representation> {
    named(model, &attribute::<String>(value, "representation")?)
}

/// A list of parts of some classes.
fn list<'py, T>(
    model: &Model,
    parts: &Bound<'py, PyAny>,
    name: &str,
    classes: &[&str],
    one: fn(&Model, &Bound<'py, PyAny>) -> PyResult<T>,
) -> PyResult<Vec<T>> {
    let all: Option<Vec<Bound<'_, PyAny>>> = parts.get_item(name)?.extract()?;
    let all = all.unwrap_or_default();
    for (k, one) in all.iter().enumerate() {
        check_kind(format_args!("{name}[{k}]"), one, "sim", classes, "")?;
    }
    all.iter().map(|own| one(model, own)).collect()
}

/// Coefficients of joints by name.
fn coefficients_of(value: &Bound<'_, PyAny>) -> PyResult<Vec<(String, f64)>> {
    let joints = value.getattr("joints")?.call_method0("items")?;
    joints.try_iter()?.map(|item| item?.extract()).collect()
}

fn external_force_of(model: &Model, value: &Bound<'_, PyAny>) -> PyResult<ExternalForce> {
    let place = anchor_of(model, "place", value)?;
    let (force, axes) = (force_of(value, "force")?, axes_of(model, value)?);
    guarded(|| ExternalForce::constant(place, force, axes))
}

/// Adds to a simulator what its description in Python names, besides contacts.
pub(crate) fn with_parts(
    mut simulator: Simulator,
    parts: &Bound<'_, PyAny>,
) -> PyResult<Simulator> {
    let model = &simulator.model().clone();
    // Those that a scene has stay.
    macro_rules! add {
        ($name:ident by $with:ident, $classes:expr, $one:expr) => {
            let all = list(model, parts, stringify!($name), &$classes, $one)?;
            let all = [simulator.$name(), &all].concat();
            simulator = simulator.$with(all);
        };
    }
    let constraints = ["Weld", "Ball", "Distance", "Coupler", "Tendon"];
    add!(constraints by with_constraints, constraints, constraint_of);
    add!(external_forces by with_external_forces, ["ExternalForce"], external_force_of);
    add!(frame_actuators by with_frame_actuators, ["FrameActuator"], frame_actuator_of);
    add!(tendon_servos by with_tendon_servos, ["TendonServo"], tendon_servo_of);
    let simulator = with_sleeping(simulator, parts)?;
    super::activations::add(simulator, parts)
}

fn tendon_servo_of(model: &Model, value: &Bound<'_, PyAny>) -> PyResult<TendonServo> {
    let name: String = attribute(value, "name")?;
    let joints = coefficients_of(value)?;
    let joints: Vec<(&str, f64)> = joints.iter().map(|(name, c)| (&**name, *c)).collect();
    let missing = || invalid!("the tendon \"{name}\" has no servo");
    let servo = servo_of(value)?.ok_or_else(missing)?;
    let made = TendonServo::new(model, name.clone(), &joints, servo).or_raise()?;
    match attribute(value, "effort")? {
        Some(effort) => guarded(|| made.with_effort(effort)),
        None => Ok(made),
    }
}

fn frame_actuator_of(model: &Model, value: &Bound<'_, PyAny>) -> PyResult<FrameActuator> {
    let name: String = attribute(value, "name")?;
    let place = anchor_of(model, "place", value)?;
    let (wrench, axes) = (force_of(value, "wrench")?, axes_of(model, value)?);
    let limits: Option<(f64, f64)> = attribute(value, "limits")?;
    let servo = servo_of(value)?;
    guarded(|| {
        let actuator = FrameActuator::new(name, place, wrench, axes);
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

/// The simulator with the sleep that its parts name: `True` for the default, `False` for none, or (speed, time).
fn with_sleeping(simulator: Simulator, parts: &Bound<'_, PyAny>) -> PyResult<Simulator> {
    let given = parts.get_item("sleeping")?;
    // A scene has its own, which only a part replaces.
    if given.is_none() {
        return Ok(simulator);
    }
    let sleeping = match given.extract::<bool>() {
        Ok(sleeps) => sleeps.then(Sleeping::default),
        Err(_) => {
            let wrong = |_| {
                invalid!(
                    "sleeping is {given}, expected True, False, or (speed in m/s and rad/s, time in s)"
                )
            };
            let [speed, time] = given.extract().map_err(wrong)?;
            Some(Sleeping { speed, time })
        }
    };
    guarded(|| simulator.with_sleeping(sleeping))
}
